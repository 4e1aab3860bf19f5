#include "transport/files/tensor_file.h"

#include <bit>
#include <cstdint>
#include <string_view>

#include "transport/files/input_file.h"

namespace raylex::transport {

namespace {

constexpr std::string_view magic{"tensor_file", 12};  // with its zero byte
constexpr std::size_t most_fields = 1024, most_dimensions = 8;

class TensorBytes {
  public:
    explicit TensorBytes(const std::string& content) : content_(content) {}

    /// The next `size` bytes as an unsigned number; beyond the end it returns 0, and failed() becomes true.
    std::uint64_t number(std::size_t size) {
        if (!has(at_, size)) {
            failed_ = true;
            return 0;
        }
        const std::uint64_t value = number_at(at_, size);
        at_ += size;
        return value;
    }
    std::string text(std::size_t size) {
        if (!has(at_, size)) {
            failed_ = true;
            return {};
        }
        at_ += size;
        return content_.substr(at_ - size, size);
    }
    [[nodiscard]] bool has(std::uint64_t begin, std::uint64_t size) const {
        return begin <= content_.size() && size <= content_.size() - begin;
    }
    [[nodiscard]] std::uint64_t number_at(std::size_t begin, std::size_t size) const {
        std::uint64_t value = 0;
        for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(content_[begin + i]);
        return value;
    }
    [[nodiscard]] bool failed() const { return failed_; }

  private:
    const std::string& content_;
    std::size_t at_ = 0;
    bool failed_ = false;
};

enum class Stored : std::uint8_t { byte = 1, single = 10, full = 11 };  // the types of the format that occur

std::size_t size_of(Stored type) {
    return type == Stored::byte ? 1 : type == Stored::single ? 4 : type == Stored::full ? 8 : 0;
}

float value_at(const TensorBytes& bytes, std::size_t begin, Stored type) {
    const std::uint64_t bits = bytes.number_at(begin, size_of(type));
    if (type == Stored::single) return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    if (type == Stored::full) return static_cast<float>(std::bit_cast<double>(bits));
    return static_cast<float>(bits);
}

}  // namespace

Result<std::map<std::string, Tensor>> read_tensor_file(const std::string& path) {
    const Result<std::string> content = read_file(path, NamedBy::file, "a tensor file (.bsdf)");
    if (!content) return content.error();
    const auto damaged = [&](const std::string& what) { return error_at({path, 0, 0}, "tensor file: " + what); };
    TensorBytes bytes(*content);
    if (bytes.text(magic.size()) != magic) return damaged("expected it to begin with 'tensor_file'");
    const std::uint64_t major = bytes.number(1), minor = bytes.number(1), fields = bytes.number(4);
    if (major != 1 || minor != 0)
        return damaged("its version is " + std::to_string(major) + "." + std::to_string(minor) + "; expected 1.0");
    if (fields > most_fields)
        return damaged("it claims " + std::to_string(fields) + " fields; expected at most " +
                       std::to_string(most_fields));
    std::map<std::string, Tensor> result;
    std::uint64_t total = 0;
    for (std::uint64_t f = 0; f < fields; ++f) {
        const std::string name = bytes.text(bytes.number(2));
        const std::uint64_t dimensions = bytes.number(2);
        const auto type = static_cast<Stored>(bytes.number(1));
        const std::uint64_t begin = bytes.number(8);
        if (bytes.failed()) return damaged("it ends within the description of field " + std::to_string(f));
        if (dimensions > most_dimensions)
            return damaged("field '" + name + "' has " + std::to_string(dimensions) +
                           " dimensions; expected at most 8");
        Tensor tensor;
        std::uint64_t count = 1;
        for (std::uint64_t d = 0; d < dimensions; ++d) {
            const std::uint64_t extent = bytes.number(8);
            tensor.shape.push_back(extent);
            // A value takes at least a byte, so a count beyond the file's size is wrong for every type.
            if (extent > content->size() || count * extent > content->size())
                return damaged("field '" + name + "' is larger than the file");
            count *= extent;
        }
        if (bytes.failed()) return damaged("it ends within the shape of field '" + name + "'");
        if (size_of(type) == 0) continue;
        if (!bytes.has(begin, count * size_of(type))) return damaged("field '" + name + "' reaches beyond its end");
        // Without this check, a small file whose fields share bytes could need any amount of memory.
        total += count * size_of(type);
        if (total > content->size()) return damaged("its fields overlap: together they are larger than the file");
        tensor.values.resize(count);
        for (std::uint64_t i = 0; i < count; ++i) tensor.values[i] = value_at(bytes, begin + i * size_of(type), type);
        result[name] = std::move(tensor);
    }
    return result;
}

}  // namespace raylex::transport
