// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/live.h"

#include <poll.h>
#include <spdlog/spdlog.h>

#include <cerrno>
#include <chrono>

#include "lodestar/app/realtime.h"

namespace lodestar::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kGreeting{1};  // wall time between HEALTH before the first frame

int milliseconds_until(Clock::time_point time) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(time - Clock::now()).count();
  return left > 0 ? static_cast<int>(left) : 0;
}

/// Before the bus, so that LCM's receiving thread gets the same priority: it shares a lock with the
/// frame path.
std::int8_t schedule(bool realtime) {
  if (!realtime || use_realtime_scheduling()) return 0;
  spdlog::warn("--realtime: SCHED_FIFO is not permitted (it wants CAP_SYS_NICE)");
  return samples::kWarningRealtime;
}

}  // namespace

Live::Live(const navigator::Config& config, const std::string& url, bool realtime)
    : warning_(schedule(realtime)), session_(config, *this), bus_(url, *this) {
  if (realtime && !lock_memory()) {
    spdlog::warn("--realtime: mlockall is not permitted (it wants CAP_IPC_LOCK)");
    warning_ = samples::kWarningRealtime;
  }
}

void Live::run(const StopSignals& stop) {
  pollfd sources[2] = {{bus_.descriptor(), POLLIN, 0}, {stop.descriptor(), POLLIN, 0}};
  Clock::time_point greeting = Clock::now();
  while (true) {
    if (frames_ == 0 && Clock::now() >= greeting) {
      session_.send_health();
      greeting += kGreeting;
    }
    const int ready = poll(sources, 2, frames_ == 0 ? milliseconds_until(greeting) : -1);
    if (ready < 0 && errno != EINTR) throw bus::BusError("the bus failed: poll");
    if (ready <= 0) continue;
    if (sources[1].revents != 0) return;
    if (sources[0].revents != 0 && !bus_.handle()) throw bus::BusError("the bus failed: receive");
  }
}

void Live::receive(samples::Channel channel, const void* data, std::size_t size) {
  const Clock::time_point start = Clock::now();
  const navigator::Outputs* outputs = session_.receive(channel, data, size);
  if (outputs == nullptr) return;
  cycle_.add(std::chrono::duration<double>(Clock::now() - start).count());
  ++frames_;
  reporter_.watch(*outputs);
}

void Live::send(const char* channel, const bus::Message& message) {
  if (!bus_.publish(channel, message.bytes.data(), message.size)) ++unsent_;
}

void Live::complete(samples::Health& health) {
  health.cycle = cycle_.take();
  health.warning = static_cast<std::int8_t>(health.warning | warning_);
  reporter_.watch(health, unsent_);
  health.log_dropped = log_.dropped();
}

}  // namespace lodestar::app
