// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lodestar::app {

/// Puts this thread, and those it starts from now on, under SCHED_FIFO. False where not permitted.
bool use_realtime_scheduling();

/// Keeps the memory of the process, present and future, from being paged out. False where not
/// permitted.
bool lock_memory();

}  // namespace lodestar::app
