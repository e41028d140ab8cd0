// Keeps CHOLMOD from starting threads.
#pragma once

namespace tetraction {

/// While it lives, OpenMP regions entered from this thread run on one thread. CHOLMOD asks for four
/// whatever the machine has; on fewer cores they wait for each other most of the time (half as long
/// again for a step of 6,000 tetrahedra on two cores).
class SerialOpenMp {
 public:
  SerialOpenMp();
  ~SerialOpenMp();
  SerialOpenMp(const SerialOpenMp&) = delete;
  SerialOpenMp& operator=(const SerialOpenMp&) = delete;

 private:
  int levels_;
};

}  // namespace tetraction
