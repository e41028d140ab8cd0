// Work at the end of a scope, however it is left.
#pragma once

#include <utility>

namespace tetraction {

/// Calls a function when it is destroyed, unless it was released before.
template <class Function>
class ScopeExit {
 public:
  explicit ScopeExit(Function function) : function_(std::move(function)) {}
  ~ScopeExit() {
    if (is_armed_) function_();
  }
  ScopeExit(const ScopeExit&) = delete;
  ScopeExit& operator=(const ScopeExit&) = delete;
  void release() { is_armed_ = false; }

 private:
  Function function_;
  bool is_armed_ = true;
};

}  // namespace tetraction
