#include "quiet_vtk.h"

#include <vtkCallbackCommand.h>
#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <algorithm>

namespace tetraction {

// An output window of VTK that stores errors and warnings instead of printing them.
class CollectingWindow : public vtkOutputWindow {
 public:
  static CollectingWindow* New();
  vtkTypeMacro(CollectingWindow, vtkOutputWindow);

  void DisplayText(const char* text) override {
    if (messages != nullptr && text != nullptr) messages->text_ += text;
  }
  VtkMessages* messages = nullptr;
};
vtkStandardNewMacro(CollectingWindow);

std::recursive_mutex& VtkMessages::only_one() {
  static std::recursive_mutex mutex;
  return mutex;
}

VtkMessages::VtkMessages() : lock_(only_one()) {
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  vtkOutputWindow* previous = vtkOutputWindow::GetInstance();
  previous->Register(nullptr);
  previous_window_ = previous;
  auto window = vtkSmartPointer<CollectingWindow>::New();
  window->messages = this;
  vtkOutputWindow::SetInstance(window);
}

VtkMessages::~VtkMessages() {
  auto* previous = static_cast<vtkOutputWindow*>(previous_window_);
  vtkOutputWindow::SetInstance(previous);
  previous->UnRegister(nullptr);
}

void VtkMessages::watch(vtkObject* object) {
  auto command = vtkSmartPointer<vtkCallbackCommand>::New();
  command->SetClientData(this);
  command->SetCallback(&VtkMessages::collect);
  object->AddObserver("ErrorEvent", command);
  object->AddObserver("WarningEvent", command);
}

void VtkMessages::collect(vtkObject*, unsigned long, void* self, void* text) {
  if (text != nullptr) static_cast<VtkMessages*>(self)->text_ += static_cast<const char*>(text);
}

std::string VtkMessages::first() const {
  // "ERROR: In file.cxx, line 12\nvtkClass (0x1234): what is wrong!\n\n": only the last part
  // is meant for a user.
  std::string text = text_;
  if (const auto place = text.find(" In "); place < text.find('\n')) {
    text.erase(0, text.find('\n') + 1);
  }
  text.resize(std::min(text.find('\n'), text.size()));
  if (const auto name = text.find(' '); name != text.npos && text.compare(name, 4, " (0x") == 0) {
    if (const auto mark = text.find("): "); mark != std::string::npos) text.erase(0, mark + 3);
  }
  // This is a consequence of an error that was not reported. Its addresses tell a user nothing.
  if (text.rfind("Algorithm ", 0) == 0) return "a part of it is missing or malformed";
  text.erase(text.find_last_not_of(" .!") + 1);
  return text;
}

}  // namespace tetraction
