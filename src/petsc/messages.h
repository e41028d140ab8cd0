// Lists of numbers between processes, of any size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "all_to_all.h"
#include "processes.h"

namespace tetraction::petsc {

/// Waits until the other process has room for the bytes or takes them.
void send_bytes(const void* data, std::size_t size, int to);
/// Waits for so many bytes.
void receive_bytes(void* data, std::size_t size, int from);

/// Sends a list that receive_list() of the process `to` returns.
template <class Item>
void send_list(const Item* items, std::size_t count, int to) {
  static_assert(std::is_trivially_copyable_v<Item>);
  const std::uint64_t size = count;
  send_bytes(&size, sizeof size, to);
  send_bytes(items, count * sizeof(Item), to);
}

template <class Item>
std::vector<Item> receive_list(int from) {
  std::uint64_t size = 0;
  receive_bytes(&size, sizeof size, from);
  std::vector<Item> items(size);
  receive_bytes(items.data(), items.size() * sizeof(Item), from);
  return items;
}

/// The processes of an MPI run.
class MpiAllToAll : public AllToAll {
 public:
  explicit MpiAllToAll(const Processes& processes)
      : rank_(processes.rank()), count_(processes.count()) {}
  int rank() const override { return rank_; }
  int count() const override { return count_; }

 private:
  std::vector<std::size_t> exchange_sizes(const std::vector<std::size_t>& sent) const override;
  void exchange_bytes(const std::vector<Block<const void*>>& sent,
                      const std::vector<Block<void*>>& received) const override;

  int rank_;
  int count_;
};

}  // namespace tetraction::petsc
