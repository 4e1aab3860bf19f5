// Runs the built program as a user does: in a folder of its own, with captured output.
#pragma once

#include <string>
#include <vector>

namespace raylex::test {

struct Outcome {
    int code = -1;  ///< exit code; 128 + signal when a signal ended it
    std::string out, err;
};

/// A folder that is removed with everything in it.
class Folder {
  public:
    Folder();
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    [[nodiscard]] std::string path(const std::string& name = {}) const;
    std::string write(const std::string& name, const std::string& text) const;  ///< returns the path
    [[nodiscard]] bool has(const std::string& name) const;
    [[nodiscard]] std::string read(const std::string& name) const;
    /// Names of everything in it, sorted.
    [[nodiscard]] std::vector<std::string> names() const;

  private:
    std::string path_;
};

/// Runs a line of bash in `folder`; $RAYLEX is the program.
Outcome run_shell(const Folder& folder, const std::string& line);
/// Runs the program with `arguments` as bash reads them.
Outcome run_raylex(const Folder& folder, const std::string& arguments);

/// A plane under a point light and an area light, 16x16 pixels, 4 samples.
std::string small_scene();

}  // namespace raylex::test
