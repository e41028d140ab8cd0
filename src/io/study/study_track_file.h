// The motion of a run of a study in a file of its own, from which its errors are computed.
#pragma once

#include <memory>
#include <string>

#include "tetraction/simulation/motion_track.h"

namespace tetraction {

/// The name of the file in the folder of a run.
inline constexpr const char* kStudyTrackFile = "study_track.bin";

/// Writes the track of the run with this digest (RunDigests). Throws OutputError.
void write_study_track(const std::string& path, const MotionTrack& track,
                       const std::string& digest);

/// The track in this file, or null if the file is not there, is damaged, or belongs to another run.
std::shared_ptr<const MotionTrack> read_study_track(const std::string& path,
                                                    const std::string& digest);

}  // namespace tetraction
