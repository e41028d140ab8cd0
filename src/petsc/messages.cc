#include "messages.h"

#include <mpi.h>

#include <algorithm>

namespace tetraction::petsc {
namespace {

constexpr int kTag = 5;
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

}  // namespace tetraction::petsc
