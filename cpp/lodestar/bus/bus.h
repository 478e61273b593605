// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

#include "lodestar/samples/counters.h"

struct _lcm_t;

namespace lodestar::bus {

/// The bus that a person gets who names no other. ttl=0: nothing leaves the host.
inline constexpr const char* kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";

/// No bus: one line with the URL and the usual remedy.
class BusError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Who is told of messages: raw bytes of an input channel, to be checked by decode().
class Receiver {
 public:
  virtual ~Receiver() = default;
  virtual void receive(samples::Channel channel, const void* data, std::size_t size) = 0;
};

/// LCM, reduced to what a flight computer needs: the input channels by name, raw bytes in and out.
///
/// What LCM itself does on the way: a thread of its own reads the socket into a ring buffer of
/// 200 KB that it enlarges when a burst fills it; handle() and that thread share a lock for as long
/// as a buffer changes hands. Its table of channel names grows by one entry for each new name it
/// hears. Publishing is one sendmsg() without allocation.
class Bus {
 public:
  /// Subscribes to every input channel. Throws BusError if there is no bus at `url`.
  Bus(const std::string& url, Receiver& receiver);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// A descriptor that is readable when handle() has a message.
  int descriptor() const;

  /// Hands one message to the receiver; waits for it if there is none. What the receiver throws
  /// comes out here, not through LCM. False if LCM failed.
  bool handle();

  /// False if the message was not sent.
  bool publish(const char* channel, const void* data, std::size_t size);

 private:
  struct Subscription {
    Bus* bus = nullptr;
    samples::Channel channel{};
  };
  struct Destroy {
    void operator()(_lcm_t* lcm) const;
  };
  struct Callback;

  Receiver& receiver_;
  std::array<Subscription, samples::kChannels> subscriptions_;
  std::unique_ptr<_lcm_t, Destroy> lcm_;
  std::exception_ptr thrown_;
};

}  // namespace lodestar::bus
