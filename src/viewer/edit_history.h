// Undo and redo of edits of a body that has moved on since.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Whether `later` replaces all that `earlier` sets, so that the latter need not be made if both wait.
bool replaces(const Edit& later, const Edit& earlier);

/// An edit that was made.
struct MadeEdit {
  Edit edit;             ///< with the number of what it added
  std::string what;      ///< for people
  bool goes_on = false;  ///< it is undone together with the one before
};

/// Makes edits and takes them back by others that set what was set before: all of them ordinary edits
/// at the present time, so that what a person does and undoes can be recorded and replayed.
///
/// An edit that changed positions or momenta themselves (SetMomentum, ShiftState) is taken back by the
/// opposite shift; any edit at a state from which no step was made yet also gives back that state.
class EditHistory {
 public:
  /// Makes an edit of the session and whatever belongs to it (records, marks). Throws InputError.
  using Apply = std::function<void(const Edit&, const std::string& what)>;

  EditHistory(const Session& session, Apply apply);

  /// Throws InputError, with everything as it was.
  void make(const Edit& edit, const std::string& what, bool goes_on);
  /// These do nothing if there is nothing to undo or redo. Throw InputError, with everything as it was,
  /// where the body does not allow it now.
  void undo();
  void redo();
  /// Empty: none.
  std::string undo_text() const { return undo_.empty() ? "" : undo_.back().what; }
  std::string redo_text() const { return redo_.empty() ? "" : redo_.back().what; }
  /// A step was made.
  void stepped();
  /// All edits that are in force, in their order: those that were not undone.
  std::vector<MadeEdit> in_force() const;

 private:
  // What one part of the body was before it was edited; nothing: it was not there.
  struct ForceBefore {
    std::size_t index;
    std::optional<ForceSettings> force;
  };
  struct FixBefore {
    std::size_t index;
    std::optional<PresentFix> fix;
    Matrix targets_after{};  // of its vertices, where they all are still held
  };
  struct ConstraintBefore {
    std::size_t index;
    std::optional<ConstraintSettings> constraint;
  };
  using Before = std::variant<SetMaterial, SetTime, SetSolver, SetDamping, SetEnvironment,
                              ForceBefore, FixBefore, ConstraintBefore>;
  // What is undone at once.
  struct Entry {
    std::string what;
    std::vector<Edit> edits;  // to do it again: with the numbers of what they added
    std::vector<Before> before;
    // Positions and momenta before, until a step is made.
    std::optional<State> state;
    // What SetMomentum and ShiftState added to the positions and momenta; empty: nothing.
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
