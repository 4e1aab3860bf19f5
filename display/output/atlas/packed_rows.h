// Rows of OpenEXR parts as they stand in the file: for each channel the values of a row side by side, no copies made by
// sample. OpenEXR's C++ interface hands deep samples over one by one, which took most of the time of asking an atlas.
// Includes nothing of OpenEXR's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lpe/result.h"

namespace raylex::display {

class PackedRows {
  public:
    enum class Type : std::uint8_t { half, single, uint };
    struct Channel {
        std::string name;
        Type type = Type::single;
        [[nodiscard]] std::size_t bytes() const { return type == Type::half ? 2 : 4; }
    };

    /// One row of a part.
    class Row {
      public:
        /// [pixel + 1] where its samples begin; those of a flat part are its pixels.
        [[nodiscard]] std::span<const std::uint32_t> begin() const { return begin_; }
        [[nodiscard]] std::size_t sample_count() const { return begin_.empty() ? 0 : begin_.back(); }
        /// `plane`: of PackedRows::plane(), whose type is Value's; halves are std::uint16_t.
        template <class Value>
        [[nodiscard]] Value value(std::size_t plane, std::size_t sample) const {
            Value read;
            std::memcpy(&read, bytes_.data() + offset_[plane] + sample * sizeof(Value), sizeof(Value));
            return read;
        }

      private:
        friend class PackedRows;
        std::vector<std::uint32_t> begin_;
        std::vector<std::size_t> offset_;  // [plane]
        std::vector<std::byte> bytes_;
    };

    /// A file that is held open, by all of its parts together.
    class File;
    /// Of a file that has been looked at (check_exr_file). Errors: it cannot be opened; it is damaged.
    static Result<std::shared_ptr<const File>> open_file(const std::string& path);
    /// `part`: its number in the file. Errors: no such part; rows that are packed several together, and deep ones that
    /// are not packed, neither of which raylex writes.
    static Result<std::unique_ptr<PackedRows>> open(std::shared_ptr<const File> file, int part);
    ~PackedRows();

    /// In the order of planes.
    [[nodiscard]] std::span<const Channel> channels() const;
    /// The plane of a channel; -1 where the part has none of this name and type.
    [[nodiscard]] int plane(const std::string& name, Type type) const;
    /// `y` in the part's data window. May be called by several threads at once. Errors: what is truncated or damaged.
    Status read(int y, Row& row) const;

  private:
    struct Impl;
    explicit PackedRows(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace raylex::display
