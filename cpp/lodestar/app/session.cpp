// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/session.h"

#include <algorithm>
#include <string_view>
#include <type_traits>
#include <variant>

#include "lodestar/bus/channels.h"

namespace lodestar::app {

const navigator::Outputs* Session::receive(samples::Channel channel, const void* data,
                                           std::size_t size) {
  return std::visit(
      [&](const auto& message) -> const navigator::Outputs* {
        using Type = std::decay_t<decltype(message)>;
        if constexpr (std::is_same_v<Type, samples::Reason>) {
          navigator_.count_rejection(channel, message);
        } else if constexpr (std::is_same_v<Type, samples::BodyRates>) {
          return step(message);
        } else {
          navigator_.offer(message);
        }
        return nullptr;
      },
      bus::decode(channel, data, size));
}

const navigator::Outputs* Session::step(const samples::BodyRates& rates) {
  const navigator::Outputs* outputs = navigator_.step(rates);
  if (outputs == nullptr) return nullptr;
  send(bus::kSahrs, outputs->sahrs);
  send(bus::kNav, outputs->nav);
  if (outputs->ins_monitor_due) send(bus::kInsMonitor, outputs->ins_monitor);
  if (outputs->health_due) {
    send(bus::kSmduCalibration, outputs->smdu_calibration);
    send_health();
  }
  return outputs;
}

void Session::send_health() {
  samples::Health health = navigator_.health();
  constexpr std::string_view kVersion = LODESTAR_VERSION;
  std::copy_n(kVersion.begin(), std::min(kVersion.size(), health.build_version.size()),
              health.build_version.begin());
  sink_.complete(health);
  send(bus::kHealth, health);
}

template <class Sample>
void Session::send(const char* channel, const Sample& sample) {
  bus::encode(sample, message_);
  sink_.send(channel, message_);
}

}  // namespace lodestar::app
