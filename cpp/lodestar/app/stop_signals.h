// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace lodestar::app {

/// SIGINT and SIGTERM as something to look at between two frames, instead of something that
/// interrupts one. To be made before any thread, which inherits that the signals are blocked.
class StopSignals {
 public:
  /// Throws std::system_error.
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Readable once a signal has arrived.
  int descriptor() const { return descriptor_; }

  bool requested() const;

 private:
  int descriptor_;
};

}  // namespace lodestar::app
