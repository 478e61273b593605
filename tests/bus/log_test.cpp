// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "lodestar/bus/log_reader.h"
#include "lodestar/bus/log_writer.h"

namespace lodestar::bus {
namespace {

class Log : public testing::Test {
 protected:
  Log() : path_(testing::TempDir() + "lodestar_log_" + std::to_string(getpid()) + ".lcm") {}
  ~Log() override { std::filesystem::remove(path_); }

  void write_two_events() const {
    LogWriter writer(path_);
    writer.write(1'000'000, "EFCS.RATES", "first", 5);
    writer.write(-5, "GPS", "", 0);
    writer.close();
  }

  std::string contents() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  void overwrite(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

  /// The message of the error that reading to the end meets; empty if it meets none.
  std::string error_of_reading() const {
    try {
      LogReader reader(path_);
      for (LogEvent event; reader.next(event);) {
      }
    } catch (const LogError& error) {
      return error.what();
    }
    return "";
  }

  std::string path_;
};

TEST_F(Log, GivesBackWhatWasWritten) {
  write_two_events();
  LogReader reader(path_);
  LogEvent event;
  ASSERT_TRUE(reader.next(event));
  EXPECT_EQ(event.timestamp_us, 1'000'000);
  EXPECT_EQ(event.channel, "EFCS.RATES");
  EXPECT_EQ(std::string(event.data, event.data + event.size), "first");
  ASSERT_TRUE(reader.next(event));
  EXPECT_EQ(event.timestamp_us, -5);
  EXPECT_EQ(event.channel, "GPS");
  EXPECT_EQ(event.size, 0u);
  EXPECT_FALSE(reader.next(event));
  reader.rewind();
  ASSERT_TRUE(reader.next(event));
  EXPECT_EQ(event.channel, "EFCS.RATES");
}

TEST_F(Log, IsReadByLcm) {
  write_two_events();
  lcm::LogFile log(path_, "r");
  const lcm::LogEvent* event = log.readNextEvent();
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->eventnum, 0);
  EXPECT_EQ(event->timestamp, 1'000'000);
  EXPECT_EQ(event->channel, "EFCS.RATES");
  EXPECT_EQ(std::string(static_cast<char*>(event->data), 5), "first");
  event = log.readNextEvent();
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->eventnum, 1);
  EXPECT_EQ(event->channel, "GPS");
  EXPECT_EQ(log.readNextEvent(), nullptr);
}

TEST_F(Log, ReadsWhatLcmWrites) {
  {
    lcm::LogFile log(path_, "w");
    char data[] = "abc";
    lcm::LogEvent event{0, 42, "SMDU", 3, data};
    ASSERT_EQ(log.writeEvent(&event), 0);
  }
  LogReader reader(path_);
  LogEvent event;
  ASSERT_TRUE(reader.next(event));
  EXPECT_EQ(event.timestamp_us, 42);
  EXPECT_EQ(event.channel, "SMDU");
  EXPECT_EQ(event.size, 3u);
  EXPECT_FALSE(reader.next(event));
}

TEST_F(Log, RefusesEveryTornEndAndNamesFileAndOffset) {
  write_two_events();
  const std::string whole = contents();
  const std::size_t second = 28 + 10 + 5;  // header, channel, data of the first event
  for (std::size_t size = 1; size < whole.size(); ++size) {
    overwrite(whole.substr(0, size));
    const std::string error = error_of_reading();
    if (size == second) {
      EXPECT_EQ(error, "");
      continue;
    }
    EXPECT_NE(error.find(path_ + ": truncated"), std::string::npos) << size << error;
    EXPECT_NE(error.find(size < second ? "byte 0 of" : "byte 43 of"), std::string::npos) << error;
  }
}

TEST_F(Log, RefusesForeignFiles) {
  overwrite("PK\x03\x04 an archive of arrays, not a log");
  EXPECT_NE(error_of_reading().find("not an LCM log"), std::string::npos);
  overwrite("");
  EXPECT_NE(error_of_reading().find("empty"), std::string::npos);
}

TEST_F(Log, RefusesJunkBetweenEvents) {
  write_two_events();
  std::string bytes = contents();
  bytes.insert(43, "junk");
  overwrite(bytes);
  EXPECT_NE(error_of_reading().find("byte 43 of"), std::string::npos);
}

TEST_F(Log, RefusesForgedLengthsBeforeItAllocates) {
  write_two_events();
  const std::string whole = contents();
  std::string bytes = whole;
  bytes[24] = '\x7f';  // first byte of the data length: 2 GB
  overwrite(bytes);
  EXPECT_NE(error_of_reading().find("truncated"), std::string::npos);
  bytes = whole;
  bytes[20] = '\xff';  // first byte of the channel length
  overwrite(bytes);
  EXPECT_NE(error_of_reading().find("channel name"), std::string::npos);
}

TEST_F(Log, SaysWhichFileIsMissingOrCannotBeWritten) {
  EXPECT_NE(error_of_reading().find(path_ + ": No such file"), std::string::npos);
  try {
    LogWriter writer("/no/such/folder/out.lcm");
    FAIL() << "opened a file in a folder that does not exist";
  } catch (const LogError& error) {
    EXPECT_NE(std::string(error.what()).find("/no/such/folder/out.lcm"), std::string::npos);
  }
}

TEST_F(Log, NoticesAFullDisk) {
  LogWriter writer("/dev/full");
  const std::vector<std::uint8_t> block(1 << 20);
  EXPECT_THROW(
      {
        writer.write(0, "GPS", block.data(), block.size());
        writer.close();
      },
      LogError);
}

}  // namespace
}  // namespace lodestar::bus
