// A folder for the files of one test.
#pragma once

#include <string>
#include <vector>

namespace raylex::test {

/// A new folder that is removed with its contents. Its name has a blank, like many users' folders.
class Folder {
  public:
    Folder();
    ~Folder();
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    /// Returns the path of an entry, or of the folder.
    [[nodiscard]] std::string path(const std::string& name = {}) const;
    /// Writes a file; also makes the folders of "sub/folder/name". Returns the path.
    std::string write(const std::string& name, const std::string& bytes) const;
    [[nodiscard]] bool has(const std::string& name) const;
    [[nodiscard]] std::string read(const std::string& name) const;
    /// Returns the names of all entries, sorted.
    [[nodiscard]] std::vector<std::string> names() const;

  private:
    std::string path_;
};

/// Returns the content of a file; empty if there is no such file.
std::string read_bytes(const std::string& path);
void write_bytes(const std::string& path, const std::string& bytes);

}  // namespace raylex::test
