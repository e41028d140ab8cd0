// Undo and redo of edits. The body may have moved since an edit was made.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "numbering.h"
#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// Whether `later` sets everything that `earlier` sets. Then `earlier` need not be made if it is still
/// waiting.
bool replaces(const Edit& later, const Edit& earlier);

/// An edit that was made.
struct MadeEdit {
  Edit edit;                        ///< with the index of the entry that it added
  std::string what;                 ///< description for people
  bool continues_previous = false;  ///< whether it is undone together with the previous edit
};

/// Makes edits, and undoes them by further edits that restore the earlier settings. An undo is an
/// ordinary edit at the present time. Therefore the recording of a run can replay it.
///
/// An edit that changed positions or momenta (SetMomentum, ShiftState) is undone by the opposite
/// shift. If no step has been made since an edit, undoing it restores the positions and momenta
/// exactly.
class EditHistory {
 public:
  /// Makes an edit of the session and records it. Throws InputError.
  using Apply = std::function<void(const Edit&, const std::string& what)>;

  EditHistory(const Session& session, Apply apply);

  /// Makes an edit. Throws InputError if the session refuses it; then nothing has changed.
  void make(const Edit& edit, const std::string& what, bool continues_previous);
  /// Makes a change that is no edit of the session: act(true) makes it, and act(false) takes it back.
  void make_other(const std::string& what, const std::function<void(bool)>& act);
  /// Undoes or redoes one entry. The functions do nothing if there is none. They throw InputError if
  /// the session refuses an edit in the present state; then nothing has changed.
  void undo();
  void redo();
  /// Undoes the last entry and brings back the positions and momenta before it, at the present time.
  void go_before_last();
  /// The texts of the entries that undo() and redo() would process. Empty if there is none.
  std::string undo_text() const { return undo_.empty() ? "" : undo_.back().what; }
  std::string redo_text() const { return redo_.empty() ? "" : redo_.back().what; }
  /// Whether the next edit begins an entry.
  bool begins_entry(bool continues_previous) const {
    return !continues_previous || !can_continue_ || undo_.empty();
  }
  /// The session is again as it was before the last entry: redo() can make it again.
  void take_back();
  /// Takes over edits that were made before, which undo() does not reach, and loads of them that were
  /// undone.
  void remember(std::vector<MadeEdit> made, EntryNumbers undone_loads);
  /// Loads that edits have added and that were undone after a step. They are zero, because the session
  /// cannot take them away.
  const EntryNumbers& undone_loads() const { return undone_loads_; }
  /// Forgets what redo() could make again.
  void forget_undone() { redo_.clear(); }
  /// Must be called after each step.
  void stepped();
  /// Whether go_before_last() is possible, and the number of entries that undo() could undo.
  bool knows_state_before_last() const { return before_last_ && !undo_.empty(); }
  std::size_t undo_count() const { return undo_.size(); }
  /// Whether undo() or redo() would act on a change of make_other().
  bool undoes_other() const { return !undo_.empty() && undo_.back().act != nullptr; }
  bool redoes_other() const { return !redo_.empty() && redo_.back().act != nullptr; }
  /// All edits that have not been undone, in their order. Another thread may ask for them.
  std::vector<MadeEdit> edits_in_effect() const;

 private:
  // A load or a constraint that did not exist before an edit.
  struct Added {
    std::size_t list;
    std::size_t index;
  };
  // The state of a fix before an edit. No value if it did not exist.
  struct FixBefore {
    std::size_t index;
    std::optional<PresentFix> fix;
    Matrix targets_after{};  // targets after the edits of an entry, if the vertices are the same
  };
  // All other settings are put back by an edit.
  using Before = std::variant<Edit, Added, FixBefore>;
  // A group of edits that are undone together.
  struct Entry {
    std::string what;
    std::function<void(bool)> act;  // of make_other()
    std::vector<Edit> edits;        // for redo, with the indices of the entries that they added
    std::vector<Before> before;
    // The state before the edits. It is removed when a step is made.
    std::optional<State> state;
    // The changes of positions and momenta by SetMomentum and ShiftState. Empty if there are none.
    Vector displacement;
    Vector impulse;
  };

  struct BeforeVisitor;
  std::vector<Before> before(const Edit& edit) const;
  bool is_undone_load(const Edit& edit) const;
  Edit adding_again(Edit edit) const;
  void make(const Edit& edit, const std::string& what, Entry& entry);
  void make_all(const std::vector<Edit>& edits, const std::string& what, Entry& entry,
                bool all_or_none = true);
  void store_targets(Entry& entry) const;
  std::vector<Edit> inverse(const Entry& entry) const;
  Edit inverse(const FixBefore& before, bool at_once) const;
  std::optional<Edit> shift_back(const Entry& entry) const;
  void revert(const Entry& entry, const std::string& what, Entry& done, bool all_or_none = true);
  static std::pair<std::size_t, std::size_t> part_of(const Before& before);

  const Session& session_;
  Apply apply_;
  void to_redo();
  void drop_oldest_entry();
  static void append(const Entry& entry, std::vector<MadeEdit>& made);

  mutable std::mutex mutex_;            // of the edits in effect
  std::vector<MadeEdit> not_undoable_;  // edits of entries that were dropped, and earlier ones
  std::vector<Entry> undo_;
  std::vector<Entry> redo_;
  EntryNumbers undone_loads_;
  std::optional<State> before_last_;  // state before the last entry, if it was made, not redone
  bool can_continue_ = false;         // whether the last entry contains the last edit
};

/// The settings that the user has changed and that a run keeps when it is restarted. `made` are the
/// edits of a session that have not been undone, in their order. Returns the edits that give the same
/// settings to a session at the start of the same scene. Of several edits of one setting, only the last
/// one counts. Fixed vertices are fixed at their positions at the start, unless the edit has a target.
/// Edits of positions and momenta are left out, because they apply to the time at which they were made.
std::vector<MadeEdit> kept_settings(const std::vector<MadeEdit>& made, const Session& start);

}  // namespace tetraction::viewer
