// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/replay.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "level_flight.h"
#include "lodestar/app/session.h"
#include "lodestar/bus/channels.h"
#include "lodestar/bus/log_reader.h"
#include "lodestar/bus/log_writer.h"

namespace lodestar::app {
namespace {

class Replay : public testing::Test {
 protected:
  Replay() {
    std::filesystem::create_directory(folder_);
    bus::LogWriter writer(input_);
    for (const Sent& message : level_flight(5)) {
      writer.write(message.time_us + kLogDelay, bus::name(message.channel), message.bytes.data(),
                   message.bytes.size());
      // What a recording also holds, and what must change nothing.
      writer.write(message.time_us + kLogDelay, "TRUTH", "whatever", 8);
    }
    writer.close();
  }
  ~Replay() override { std::filesystem::remove_all(folder_); }

  Replayed run(const std::string& output) {
    return replay(navigator::Config{}, input_, output, stop_);
  }

  std::string error_of_run(const std::string& output) {
    try {
      run(output);
    } catch (const bus::LogError& error) {
      return error.what();
    }
    return "";
  }

  static std::string contents(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static constexpr std::int64_t kLogDelay = 7;  // us
  const std::string folder_ = testing::TempDir() + "lodestar_replay_" + std::to_string(getpid());
  const std::string input_ = folder_ + "/in.lcm";
  const std::string output_ = folder_ + "/out.lcm";
  StopSignals stop_;
};

TEST_F(Replay, AnswersEveryFrameWithTheTimeStampOfItsTrigger) {
  const Replayed count = run(output_);
  EXPECT_EQ(count.frames, 300);
  EXPECT_EQ(count.messages, 300 + 300 + 3 * 150 + 5);
  bus::LogReader reader(output_);
  int attitudes = 0;
  int solutions = 0;
  int healths = 0;
  for (bus::LogEvent event; reader.next(event);) {
    if (event.channel == bus::kSahrs) {
      EXPECT_EQ(event.timestamp_us,
                1'000'000 + std::int64_t{attitudes} * 1'000'000 / 60 + kLogDelay);
      ++attitudes;
    }
    solutions += event.channel == bus::kNav;
    healths += event.channel == bus::kHealth;
  }
  EXPECT_EQ(attitudes, 300);
  EXPECT_EQ(solutions, 300);
  EXPECT_EQ(healths, 5);
}

TEST_F(Replay, GivesTheSameBytesEveryTime) {
  run(output_);
  run(folder_ + "/again.lcm");
  EXPECT_FALSE(contents(output_).empty());
  EXPECT_EQ(contents(output_), contents(folder_ + "/again.lcm"));
}

/// Keeps the bytes of all messages.
struct Bytes : Sink {
  void send(const char*, const bus::Message& message) override {
    text.append(message.bytes.begin(),
                message.bytes.begin() + static_cast<std::ptrdiff_t>(message.size));
  }
  std::string text;
};

TEST_F(Replay, GivesTheBytesThatASessionGives) {
  Bytes sink;
  Session session(navigator::Config{}, sink);
  for (const Sent& message : level_flight(5)) {
    session.receive(message.channel, message.bytes.data(), message.bytes.size());
  }
  run(output_);
  std::string replayed;
  bus::LogReader reader(output_);
  for (bus::LogEvent event; reader.next(event);) {
    replayed.append(event.data, event.data + event.size);
  }
  EXPECT_EQ(replayed, sink.text);
}

TEST_F(Replay, RefusesADamagedLogBeforeItWrites) {
  std::filesystem::resize_file(input_, std::filesystem::file_size(input_) - 1);
  EXPECT_NE(error_of_run(output_).find(input_ + ": truncated"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(output_));
}

TEST_F(Replay, RefusesALogThatMakesNoFrame) {
  bus::LogWriter writer(input_);
  writer.write(0, "TRUTH", "", 0);
  writer.close();
  EXPECT_NE(error_of_run(output_).find("EFCS.RATES"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(output_));
}

TEST_F(Replay, NeverOverwritesItsInput) {
  const std::string before = contents(input_);
  EXPECT_NE(error_of_run(folder_ + "/./in.lcm").find("to be replayed"), std::string::npos);
  EXPECT_EQ(contents(input_), before);
}

TEST_F(Replay, KeepsWhatWasDoneWhenAskedToStop) {
  {
    bus::LogWriter writer(input_);
    for (const Sent& message : level_flight(60)) {
      writer.write(message.time_us, bus::name(message.channel), message.bytes.data(),
                   message.bytes.size());
    }
    writer.close();
  }
  kill(getpid(), SIGTERM);
  const Replayed count = run(output_);
  EXPECT_GT(count.frames, 0);
  EXPECT_LT(count.frames, 3600);
  std::int64_t attitudes = 0;
  bus::LogReader reader(output_);
  for (bus::LogEvent event; reader.next(event);) attitudes += event.channel == bus::kSahrs;
  EXPECT_EQ(attitudes, count.frames);
  // Take the signal, so that it does not end the test program.
  sigset_t term;
  sigemptyset(&term);
  sigaddset(&term, SIGTERM);
  int taken = 0;
  EXPECT_EQ(sigwait(&term, &taken), 0);
}

}  // namespace
}  // namespace lodestar::app
