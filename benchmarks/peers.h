// Published figures of other programs for the same beam, measured elsewhere on another machine
// (docs/performance.md): only ratios among them can be compared with ratios among ours.
#pragma once

#include <string>

namespace tetraction::benchmarks {

inline const std::string kPeerNote =
    "peers: measured elsewhere on another machine (docs/performance.md), compare ratios only";

inline const std::string kPeersExplicit = "SOFA HP 52-55, Vega 507-554; force alone: dolfinx 80";

inline const std::string kPeersStiffness = "Vega 1.1, dolfinx 1.63, deal.II 2.1";

/// ms a step of implicit rules with h = 0.01 s.
inline std::string peers_implicit(const std::string& size, bool midpoint) {
  if (midpoint) {
    return size == "S" ? "SOFA HP 7.1" : (size == "M" ? "SOFA HP 75" : "");
  }
  if (size == "S") return "Vega CG 4.7, dolfinx MUMPS 11, deal.II CHOLMOD 24, IPC 31";
  if (size == "M") return "Vega CG 62, dolfinx MUMPS 212, deal.II CHOLMOD 333, IPC 471";
  if (size == "L") return "Vega CG 658, dolfinx MUMPS 4595, deal.II CHOLMOD 5774, IPC 6750";
  return "";
}

}  // namespace tetraction::benchmarks
