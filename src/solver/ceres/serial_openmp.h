// Keeps CHOLMOD from starting threads.
#pragma once

namespace tetraction {

/// While an object of this class lives, OpenMP regions that this thread enters run on one thread.
/// CHOLMOD asks for four threads on every machine. On fewer cores these wait for each other most of
/// the time: a step of 6,000 tetrahedra on two cores takes half as long again.
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
