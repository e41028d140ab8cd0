// Lists of numbers from one process to another, of any size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

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

}  // namespace tetraction::petsc
