// The plots of a study, as cli/study_plots names them.
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
    StudyPlot{"quantity_over_parameter", "Quantities over the parameters",
              "The largest magnitude of each probe over time, or, without probes, the difference "
              "of the positions at the end from those of the first variant. Each panel varies one "
              "key. The others have their first value. The full marker is the first variant. The "
              "sensitivity is the relative change of the quantity, divided by that of the key."},
    StudyPlot{
        "error_over_step", "Error over step",
        "Error against the reference over the step size. The vertical line is the stability limit "
        "of the explicit integrators. A triangle stands where at least three runs show its slope. "
        "Crosses mark runs that did not reach the end. Below the upper edge of the grey band the "
        "error of the reference counts. Curves that coincide have one label."},
    StudyPlot{"work_precision", "Work and precision",
              "Error over the wall time of the steps. Hollow markers are steps below the stability "
              "limit, full markers steps above it. Runs that shared the cores of the machine with "
              "others are left out."},
    StudyPlot{
        "energy_over_time", "Energy error over time",
        "Magnitude of the energy error, relative to the energy that entered, with a panel for "
        "each integrator. Of each of about a hundred intervals the largest value is shown. The "
        "axis fits the runs that reached the end. Crosses mark the ends of the others. The grey "
        "band is round-off."},
    StudyPlot{"linear_momentum_over_time", "Linear momentum over time",
              "Change of those components of the linear momentum that this scene conserves."},
    StudyPlot{"angular_momentum_over_time", "Angular momentum over time",
              "Change of those components of the angular momentum about the origin that this scene "
              "conserves."},
    StudyPlot{"shapes_at_end", "Shapes at the end",
              "The surface of the body at the end, for the reference and for the coarsest run of "
              "each integrator that reached the end, on one scale. The reference stands behind "
              "each run in grey. With several variants, their references are shown."},
    StudyPlot{"cost_by_phase", "Costs by phase",
              "Wall time of each phase of the runs over the step size. Runs that shared the cores "
              "of the machine with others are left out."},
    StudyPlot{"rms_error_over_step", "Error of the whole motion over step",
              "The same for the root mean square of the position error over time."},
    StudyPlot{"energy_drift_over_step", "Energy error over step",
              "Largest energy error of each run over the step size. The grey band is round-off."},
    StudyPlot{"momentum_drift_over_step", "Balance of the momenta over step",
              "Largest change of linear and angular momentum that no impulse of a load, a "
              "constraint or damping explains, relative to the momenta. The grey band is "
              "round-off."}};

/// The endings of the files of a plot.
inline constexpr std::array kPlotEndings{".png", ".svg", ".pdf"};

}  // namespace tetraction
