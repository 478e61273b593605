// SPDX-License-Identifier: Apache-2.0
#include "lodestar/app/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

namespace lodestar::app {
namespace {

constexpr int kPriority = 50;  // the middle: below the kernel's own interrupt threads' usual place

}  // namespace

bool use_realtime_scheduling() {
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

bool lock_memory() { return mlockall(MCL_CURRENT | MCL_FUTURE) == 0; }

}  // namespace lodestar::app
