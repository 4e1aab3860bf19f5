// A place for the files of one test.
#pragma once

#include <string>
#include <vector>

namespace raylex::test {

/// A new folder that is removed with everything in it. Its name holds a space, as users' folders do.
class Folder {
  public:
    Folder();
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    /// Of something in it, or its own.
    [[nodiscard]] std::string path(const std::string& name = {}) const;
    /// Makes the folders of "sub/folder/name" too; returns the path.
    std::string write(const std::string& name, const std::string& bytes) const;
    [[nodiscard]] bool has(const std::string& name) const;
    [[nodiscard]] std::string read(const std::string& name) const;
    /// Names of everything in it, sorted.
    [[nodiscard]] std::vector<std::string> names() const;

  private:
    std::string path_;
};

/// Empty when there is no such file.
std::string read_bytes(const std::string& path);
void write_bytes(const std::string& path, const std::string& bytes);

}  // namespace raylex::test
