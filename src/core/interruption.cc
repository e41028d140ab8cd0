#include "tetraction/core/interruption.h"

namespace tetraction {
namespace {

thread_local const Interruptible* interruptible = nullptr;

}  // namespace

Interruptible::Interruptible(const std::atomic<bool>& flag, std::unique_lock<std::mutex>* lock)
    : flag_(flag), lock_(lock) {
  if (lock_ != nullptr) lock_->unlock();
  interruptible = this;
}

Interruptible::~Interruptible() {
  interruptible = nullptr;
  if (lock_ != nullptr && !lock_->owns_lock()) lock_->lock();
}

void throw_if_interrupted() {
  if (interruptible == nullptr || !interruptible->flag_) return;
  std::unique_lock<std::mutex>* const lock = interruptible->lock_;
  if (lock != nullptr && !lock->owns_lock()) lock->lock();
  throw Interrupted();
}

}  // namespace tetraction
