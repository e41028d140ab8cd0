// Lists from every process to every other one.
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction::petsc {

/// Processes that exchange lists. The functions other than rank() and count() are collective.
class AllToAll {
 public:
  virtual ~AllToAll() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;

  /// lists[p]: what this process has for process p. Returns what each process has for this one.
  template <class Item>
  std::vector<std::vector<Item>> exchange(const std::vector<std::vector<Item>>& lists) const {
    static_assert(std::is_trivially_copyable_v<Item>);
    std::vector<Block<const void*>> sent;
    std::vector<std::size_t> sizes;
    for (const std::vector<Item>& list : lists) {
      sizes.push_back(list.size() * sizeof(Item));
      sent.push_back({list.data(), sizes.back()});
    }
    std::vector<std::vector<Item>> received;
    std::vector<Block<void*>> places;
    for (const std::size_t size : exchange_sizes(sizes)) {
      received.emplace_back(size / sizeof(Item));
      places.push_back({nullptr, size});
    }
    for (std::size_t p = 0; p < places.size(); ++p) places[p].data = received[p].data();
    exchange_bytes(sent, places);
    return received;
  }
  /// The items that all processes have for this one, in the order of the processes.
  template <class Item>
  std::vector<Item> exchange_joined(const std::vector<std::vector<Item>>& lists) const {
    std::vector<Item> joined;
    for (const std::vector<Item>& list : exchange(lists)) {
      joined.insert(joined.end(), list.begin(), list.end());
    }
    return joined;
  }
  /// The lists of all processes, one after the other, on every process.
  template <class Item>
  std::vector<Item> gather(const std::vector<Item>& own) const {
    return exchange_joined(std::vector<std::vector<Item>>(static_cast<std::size_t>(count()), own));
  }

 protected:
  template <class Pointer>
  struct Block {
    Pointer data;
    std::size_t size;  // bytes
  };
  AllToAll() = default;
  AllToAll(const AllToAll&) = default;
  AllToAll& operator=(const AllToAll&) = default;

 private:
  // One entry for each process.
  virtual std::vector<std::size_t> exchange_sizes(const std::vector<std::size_t>& sent) const = 0;
  virtual void exchange_bytes(const std::vector<Block<const void*>>& sent,
                              const std::vector<Block<void*>>& received) const = 0;
};

/// The numbers 0 … total − 1, divided over processes in ranges of nearly the same length.
struct EqualRanges {
  Index total = 0;
  int count = 1;  ///< of processes

  Index first(int process) const { return total * process / count; }
  Index size(int process) const { return first(process + 1) - first(process); }
  int process_of(Index number) const {
    return static_cast<int>(((number + 1) * count - 1) / total);
  }
};

}  // namespace tetraction::petsc
