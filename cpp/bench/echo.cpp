// SPDX-License-Identifier: Apache-2.0
// Answers every EFCS.RATES with one message of the size of SAHRS and one of the size of NAV, as the
// flight computer does, and computes nothing: what a frame costs in transport alone.
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <vector>

namespace {

volatile std::sig_atomic_t stop = 0;

struct Echo {
  lcm::LCM& bus;
  std::vector<std::uint8_t> sahrs = std::vector<std::uint8_t>(204);
  std::vector<std::uint8_t> nav = std::vector<std::uint8_t>(325);

  void answer(const lcm::ReceiveBuffer*, const std::string&) {
    bus.publish("SAHRS", sahrs.data(), static_cast<unsigned>(sahrs.size()));
    bus.publish("NAV", nav.data(), static_cast<unsigned>(nav.size()));
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: bench_echo LCM-URL\n");
    return 2;
  }
  lcm::LCM bus(argv[1]);
  if (!bus.good()) {
    std::fprintf(stderr, "bench_echo: no bus at %s\n", argv[1]);
    return 2;
  }
  std::signal(SIGTERM, [](int) { stop = 1; });
  Echo echo{bus};
  bus.subscribe("EFCS.RATES", &Echo::answer, &echo);
  while (stop == 0) bus.handleTimeout(100);
  return 0;
}
