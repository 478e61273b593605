// SPDX-License-Identifier: Apache-2.0
#include "lodestar/bus/bus.h"

#include <fcntl.h>
#include <lcm/lcm.h>
#include <unistd.h>

#include <cstring>
#include <utility>

#include "lodestar/bus/channels.h"

namespace lodestar::bus {
namespace {

constexpr int kQueuedMessages = 1000;  // per channel: one second at the highest rate

/// LCM reports on standard error, over several lines, what BusError says in one.
class QuietStandardError {
 public:
  QuietStandardError() : saved_(dup(STDERR_FILENO)) {
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere < 0) return;
    dup2(nowhere, STDERR_FILENO);
    close(nowhere);
  }
  ~QuietStandardError() {
    if (saved_ < 0) return;
    dup2(saved_, STDERR_FILENO);
    close(saved_);
  }
  QuietStandardError(const QuietStandardError&) = delete;
  QuietStandardError& operator=(const QuietStandardError&) = delete;

 private:
  int saved_;
};

/// LCM takes a channel for a regular expression.
std::string escaped(const char* channel) {
  std::string pattern;
  for (const char* c = channel; *c != '\0'; ++c) {
    if (*c == '.') pattern += '\\';
    pattern += *c;
  }
  return pattern;
}

}  // namespace

struct Bus::Callback {
  static void on_message(const lcm_recv_buf_t* buffer, const char* channel, void* user) noexcept {
    const Subscription& subscription = *static_cast<const Subscription*>(user);
    // The pattern's `$` also matches before a final newline.
    if (std::strcmp(channel, name(subscription.channel)) != 0) return;
    try {
      subscription.bus->receiver_.receive(subscription.channel, buffer->data, buffer->data_size);
    } catch (...) {
      subscription.bus->thrown_ = std::current_exception();
    }
  }
};

void Bus::Destroy::operator()(_lcm_t* lcm) const { lcm_destroy(lcm); }

Bus::Bus(const std::string& url, Receiver& receiver) : receiver_(receiver) {
  const QuietStandardError quiet;
  lcm_.reset(lcm_create(url.c_str()));
  bool good = lcm_ != nullptr;
  for (std::size_t i = 0; good && i < subscriptions_.size(); ++i) {
    subscriptions_[i] = {this, static_cast<samples::Channel>(i)};
    lcm_subscription_t* subscription = lcm_subscribe(lcm_.get(), escaped(kInputNames[i]).c_str(),
                                                     Callback::on_message, &subscriptions_[i]);
    good = subscription != nullptr;
    if (good) lcm_subscription_set_queue_capacity(subscription, kQueuedMessages);
  }
  if (!good) {
    throw BusError("no bus at " + url +
                   ": check the URL and the multicast route (ip route add 224.0.0.0/4 dev lo)");
  }
}

Bus::~Bus() = default;

int Bus::descriptor() const { return lcm_get_fileno(lcm_.get()); }

bool Bus::handle() {
  const bool good = lcm_handle(lcm_.get()) == 0;
  if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
  return good;
}

bool Bus::publish(const char* channel, const void* data, std::size_t size) {
  return lcm_publish(lcm_.get(), channel, data, static_cast<unsigned int>(size)) == 0;
}

}  // namespace lodestar::bus
