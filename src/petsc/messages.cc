#include "messages.h"

#include <mpi.h>

#include <algorithm>
#include <cstring>

namespace tetraction::petsc {
namespace {

constexpr int kTag = 5;
constexpr int kExchangeTag = 6;
// Messages of MPI have sizes of type int.
constexpr std::size_t kLargest = std::size_t{1} << 28;  // bytes

}  // namespace

void send_bytes(const void* data, std::size_t size, int to) {
  const auto* bytes = static_cast<const char*>(data);
  for (std::size_t begin = 0; begin < size; begin += kLargest) {
    const std::size_t count = std::min(kLargest, size - begin);
    MPI_Send(bytes + begin, static_cast<int>(count), MPI_BYTE, to, kTag, MPI_COMM_WORLD);
  }
}

void receive_bytes(void* data, std::size_t size, int from) {
  auto* bytes = static_cast<char*>(data);
  for (std::size_t begin = 0; begin < size; begin += kLargest) {
    const std::size_t count = std::min(kLargest, size - begin);
    MPI_Recv(bytes + begin, static_cast<int>(count), MPI_BYTE, from, kTag, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
  }
}

std::vector<std::size_t> MpiAllToAll::exchange_sizes(const std::vector<std::size_t>& sent) const {
  const std::vector<std::uint64_t> own(sent.begin(), sent.end());
  std::vector<std::uint64_t> received(own.size());
  MPI_Alltoall(own.data(), 1, MPI_UINT64_T, received.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
  return {received.begin(), received.end()};
}

void MpiAllToAll::exchange_bytes(const std::vector<Block<const void*>>& sent,
                                 const std::vector<Block<void*>>& received) const {
  std::vector<MPI_Request> requests;
  const auto for_each_message = [](auto* bytes, std::size_t size, const auto& start) {
    for (std::size_t begin = 0; begin < size; begin += kLargest) {
      start(bytes + begin, static_cast<int>(std::min(kLargest, size - begin)));
    }
  };
  for (int p = 0; p < count_; ++p) {
    const auto& block = received[static_cast<std::size_t>(p)];
    if (p == rank_) continue;
    for_each_message(static_cast<char*>(block.data), block.size, [&](char* bytes, int size) {
      requests.emplace_back();
      MPI_Irecv(bytes, size, MPI_BYTE, p, kExchangeTag, MPI_COMM_WORLD, &requests.back());
    });
  }
  for (int p = 0; p < count_; ++p) {
    const auto& block = sent[static_cast<std::size_t>(p)];
    if (p == rank_) {
      if (block.size > 0) {
        std::memcpy(received[static_cast<std::size_t>(p)].data, block.data, block.size);
      }
      continue;
    }
    for_each_message(
        static_cast<const char*>(block.data), block.size, [&](const char* bytes, int size) {
          requests.emplace_back();
          MPI_Isend(bytes, size, MPI_BYTE, p, kExchangeTag, MPI_COMM_WORLD, &requests.back());
        });
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

}  // namespace tetraction::petsc
