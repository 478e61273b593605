// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/stop_signals.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <system_error>

namespace lodestar::app {

StopSignals::StopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  descriptor_ = signalfd(-1, &signals, SFD_CLOEXEC);
  if (descriptor_ < 0) throw std::system_error(errno, std::generic_category(), "signalfd");
}

StopSignals::~StopSignals() { close(descriptor_); }

bool StopSignals::requested() const {
  pollfd signal{descriptor_, POLLIN, 0};
  return poll(&signal, 1, 0) == 1;
}

}  // namespace lodestar::app
