// Undo and redo of edits of a body that may have moved since the edit.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Whether `later` replaces everything that `earlier` sets. If both are waiting, `earlier` can then
/// be left out.
bool replaces(const Edit& later, const Edit& earlier);

/// An edit that was made.
struct MadeEdit {
  Edit edit;             ///< with the number of the entry that it added
  std::string what;      ///< description for people
  bool goes_on = false;  ///< it is undone together with the edit before it
};

/// Makes edits and undoes them by further edits that restore the earlier settings. All of them are
/// ordinary edits at the present time, so that everything a person does and undoes can be recorded
/// and replayed.
///
/// An edit that changed positions or momenta (SetMomentum, ShiftState) is undone by the opposite
/// shift. If no step has been made since an edit, undoing it restores the positions and momenta
/// exactly.
class EditHistory {
 public:
  /// Function that makes an edit of the session, with its records and marks. Throws InputError.
  using Apply = std::function<void(const Edit&, const std::string& what)>;

  EditHistory(const Session& session, Apply apply);

  /// Makes an edit. If it throws InputError, nothing has changed.
  void make(const Edit& edit, const std::string& what, bool goes_on);
  /// These do nothing if there is nothing to undo or redo. They throw InputError, and nothing has
  /// changed, if the body does not allow the edit now.
  void undo();
  void redo();
  /// Empty: none.
  std::string undo_text() const { return undo_.empty() ? "" : undo_.back().what; }
  std::string redo_text() const { return redo_.empty() ? "" : redo_.back().what; }
  /// To be called after each step.
  void stepped();
  /// All edits that were not undone, in their order.
  std::vector<MadeEdit> in_force() const;

 private:
  // The settings of one part of the body before an edit. Nothing if that part did not exist.
  struct ForceBefore {
    std::size_t index;
    std::optional<ForceSettings> force;
  };
  struct FixBefore {
    std::size_t index;
    std::optional<PresentFix> fix;
    Matrix targets_after{};  // targets of its vertices, if all of them are still fixed
  };
  struct ConstraintBefore {
    std::size_t index;
    std::optional<ConstraintSettings> constraint;
  };
  using Before = std::variant<SetMaterial, SetTime, SetSolver, SetDamping, SetEnvironment,
                              ForceBefore, FixBefore, ConstraintBefore>;
  // A group of edits that are undone together.
  struct Entry {
    std::string what;
    std::vector<Edit> edits;  // for redo, with the numbers of the entries that they added
    std::vector<Before> before;
    // Positions and momenta before the edits. They are dropped when a step is made.
    std::optional<State> state;
    // The changes of positions and momenta by SetMomentum and ShiftState. Empty if there are none.
    Vector displacement;
    Vector impulse;
  };

  std::vector<Before> before(const Edit& edit) const;
  void make(const Edit& edit, const std::string& what, Entry& entry);
  void make_all(const std::vector<Edit>& edits, const std::string& what, Entry& entry,
                bool or_none = true);
  void finish(Entry& entry) const;
  std::vector<Edit> inverse(const Entry& entry) const;
  Edit inverse(const FixBefore& before, bool at_once) const;
  std::optional<Edit> shift_back(const Entry& entry) const;
  void take_back(const Entry& entry, const std::string& what, Entry& done, bool or_none = true);
  static bool same_part(const Before& a, const Before& b);

  const Session& session_;
  Apply apply_;
  void forget_oldest();
  static void append(const Entry& entry, std::vector<MadeEdit>& made);

  std::vector<MadeEdit> too_old_;  // to be undone
  std::vector<Entry> undo_;
  std::vector<Entry> redo_;
  bool can_go_on_ = false;  // the last entry is of the last edit
};

}  // namespace tetraction::viewer
