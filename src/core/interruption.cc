#include "tetraction/core/interruption.h"

namespace tetraction {
namespace {

thread_local const std::atomic<bool>* interruption_flag = nullptr;

}  // namespace

Interruptible::Interruptible(const std::atomic<bool>& flag) {
  interruption_flag = &flag;
}

Interruptible::~Interruptible() {
  interruption_flag = nullptr;
}

void throw_if_interrupted() {
  if (interruption_flag != nullptr && *interruption_flag) throw Interrupted();
}

}  // namespace tetraction
