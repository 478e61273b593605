// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/replay.h"

#include <filesystem>
#include <optional>
#include <system_error>

#include "lodestar/app/session.h"
#include "lodestar/bus/channels.h"
#include "lodestar/bus/log_reader.h"
#include "lodestar/bus/log_writer.h"

namespace lodestar::app {
namespace {

constexpr std::int64_t kMessagesBetweenLooks = 4096;  // at the stop signals

/// To the log, with the time of the message that is being handled.
class LogSink : public Sink {
 public:
  explicit LogSink(const std::string& path) : writer_(path) {}

  void at(std::int64_t timestamp_us) { timestamp_us_ = timestamp_us; }
  void close() { writer_.close(); }

  void send(const char* channel, const bus::Message& message) override {
    writer_.write(timestamp_us_, channel, message.bytes.data(), message.size);
  }

 private:
  bus::LogWriter writer_;
  std::int64_t timestamp_us_ = 0;
};

/// Reads the whole file once, so that a damaged one is refused before anything is written.
void check(bus::LogReader& reader, const std::string& path) {
  bool has_master = false;
  for (bus::LogEvent event; reader.next(event);) {
    has_master = has_master || event.channel == bus::name(samples::Channel::kBodyRates);
  }
  if (!has_master) {
    throw bus::LogError(path + ": no message on " + bus::name(samples::Channel::kBodyRates) +
                        ", which makes the frames");
  }
  reader.rewind();
}

}  // namespace

Replayed replay(const navigator::Config& config, const std::string& input,
                const std::string& output, const StopSignals& stop) {
  bus::LogReader reader(input);
  check(reader, input);
  std::error_code ignored;
  if (std::filesystem::equivalent(input, output, ignored)) {
    throw bus::LogError("--output " + output + " is the file to be replayed");
  }
  LogSink sink(output);
  Session session(config, sink);
  Replayed count;
  for (bus::LogEvent event; reader.next(event);) {
    const std::optional<samples::Channel> channel = bus::input_channel(event.channel);
    if (!channel) continue;
    sink.at(event.timestamp_us);
    if (session.receive(*channel, event.data, event.size) != nullptr) ++count.frames;
    if (++count.messages % kMessagesBetweenLooks == 0 && stop.requested()) break;
  }
  sink.close();
  count.calibration = session.navigator().calibration_result();
  return count;
}

}  // namespace lodestar::app
