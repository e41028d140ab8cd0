#include "frame_fields.h"

#include <utility>

#include "simulation/session/contact_point.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/io/obstacle_surface.h"

namespace tetraction {

Frame make_frame(const Session& session, const std::vector<std::string>& names) {
  Frame frame;
  frame.time = session.time();
  frame.step = session.step_number();
  const MechanicalSystem& system = session.system();
  const VolumeRule rule =
      system.nodal_volume() == nullptr ? VolumeRule::kElement : VolumeRule::kNodal;
  const auto list =
      chosen_quantities(names, rule, system.mesh().is_quadratic(), system.contact() != nullptr);
  std::vector<Matrix> values = values_of(session, list);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool on_cells = list[i]->domain == ValueDomain::kTetrahedra;
    (on_cells ? frame.cell_fields : frame.point_fields)
        .push_back({list[i]->name, std::move(values[i]), list[i]->is_integral});
  }
  const Contact* contact = system.contact();
  if (contact != nullptr && contact->size() > 0 && system.part() == nullptr) {
    const BodyPlace body = body_place(system.mesh().rest_positions(), session.state().position);
    const ForcePoint at = contact_point(session, session.present_state());
    frame.obstacles = obstacle_surface(*contact, body, at.time, at.load_factor);
  }
  return frame;
}

}  // namespace tetraction
