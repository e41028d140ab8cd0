// The plots of a study, as plot_study.py names them.
#pragma once

#include <array>

namespace tetraction {

struct StudyPlot {
  const char* name;  ///< of its files, without ending
  const char* heading;
  const char* caption;
};

/// All plots but those of the probes, in the order of study.html.
inline constexpr std::array kStudyPlots{
    StudyPlot{
        "error_over_step", "Error over step",
        "Error against the reference over the step size. Vertical lines are the stability "
        "limits of the explicit integrators. A triangle stands where at least three runs show "
        "its slope. Runs that did not reach the end stand in a band of their own. Where curves "
        "coincide, the lower panel shows how they differ."},
    StudyPlot{"rms_error_over_step", "Error of the whole motion over step",
              "The same for the root mean square of the position error over time."},
    StudyPlot{"work_precision", "Work and precision",
              "Error over the wall time of the steps. Hollow markers are steps below the stability "
              "limit, full markers steps above it. Runs that shared the cores of the machine with "
              "others are left out."},
    StudyPlot{
        "energy_over_time", "Energy error over time",
        "Magnitude of the energy error, relative to the energy that entered, with a panel for "
        "each integrator. The axis fits the runs that reached the end."},
    StudyPlot{"energy_drift_over_step", "Energy error over step",
              "Largest energy error of each run over the step size. The grey band is round-off."},
    StudyPlot{"linear_momentum_over_time", "Linear momentum over time",
              "Change of those components of the linear momentum that this scene conserves."},
    StudyPlot{"angular_momentum_over_time", "Angular momentum over time",
              "Change of those components of the angular momentum about the origin that this scene "
              "conserves."},
    StudyPlot{"momentum_drift_over_step", "Balance of the momenta over step",
              "Largest change of linear and angular momentum that no impulse of a load, a "
              "constraint or damping explains, relative to the momenta. The grey band is "
              "round-off."}};

/// The endings of the files of a plot.
inline constexpr std::array kPlotEndings{".png", ".svg", ".pdf"};

}  // namespace tetraction
