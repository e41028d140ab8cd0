// VTK reports errors as events and prints them. This class collects them as texts instead.
#pragma once

#include <mutex>
#include <string>

class vtkObject;

namespace tetraction {

/// While an object of this class exists, VTK prints nothing. Errors and warnings of the watched
/// objects, and those that VTK sends only to its output window, are collected. VTK has one output window:
/// another thread that makes such an object waits until this one is gone.
class VtkMessages {
 public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  void watch(vtkObject* object);
  bool empty() const { return text_.empty(); }
  /// The first message, on one line.
  std::string first() const;

 private:
  friend class CollectingWindow;
  static void collect(vtkObject*, unsigned long, void* self, void* text);
  static std::recursive_mutex& only_one();

  std::unique_lock<std::recursive_mutex> lock_;
  std::string text_;
  void* previous_window_;
};

}  // namespace tetraction
