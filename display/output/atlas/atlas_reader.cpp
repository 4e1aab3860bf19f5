#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include "display/output/atlas/atlas_layout.h"
#include "display/output/atlas/atlas_table.h"
#include "display/output/atlas/packed_rows.h"
#include "display/output/reader/exr_guard.h"
#include "display/output/writer/exr_header.h"
#include "display/services/parameters.h"

namespace raylex::display {
namespace {

std::map<std::string, std::string> header_strings(const Imf::Header& header) {
    std::map<std::string, std::string> strings;
    for (auto i = header.begin(); i != header.end(); ++i)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute()))
            strings[i.name()] = text->value();
    return strings;
}

Error no_atlas(const std::string& path) {
    return error_at({path, 0, 0},
                    "not a path atlas; expected parts 'rgba', 'words' and 'parts', as raylex render "
                    "--atlas writes them");
}

int part_named(const Imf::MultiPartInputFile& file, const char* name, bool deep) {
    for (int i = 0; i < file.parts(); ++i) {
        const Imf::Header& header = file.header(i);
        if (header.hasName() && header.name() == name && header.hasType() &&
            header.type() == (deep ? Imf::DEEPSCANLINE : Imf::SCANLINEIMAGE))
            return i;
    }
    return -1;
}

/// The planes of the three parts, -1 for a missing one. A file that lacks a required plane is not an atlas.
struct AtlasPlanes {
    std::array<int, 4 + PathAtlas::parts> flat{};
    int word = -1, eighth = -1;
    std::array<int, 3> colors{}, rests{};
    std::array<int, PathAtlas::parts> parts{};

    AtlasPlanes(const PackedRows& of_flat, const PackedRows& of_path_strings, const PackedRows& of_parts) {
        using Type = PackedRows::Type;
        const std::vector<std::string> names = AtlasLayout::flat_planes();
        for (std::size_t p = 0; p < flat.size(); ++p) flat[p] = of_flat.plane(names[p], Type::single);
        word = of_path_strings.plane(AtlasLayout::word, Type::uint);
        eighth = of_path_strings.plane(AtlasLayout::eighth, Type::half);
        for (std::size_t c = 0; c < 3; ++c) {
            colors[c] = of_path_strings.plane(AtlasLayout::colors[c], Type::single);
            rests[c] = of_path_strings.plane(AtlasLayout::rests[c], Type::single);
        }
        for (std::size_t k = 0; k < parts.size(); ++k) parts[k] = of_parts.plane(AtlasLayout::part(k), Type::half);
    }
    [[nodiscard]] bool are_all(bool is_signed) const {
        const auto there = [](const auto& planes) {
            return std::all_of(planes.begin(), planes.end(), [](int plane) { return plane >= 0; });
        };
        return word >= 0 && eighth >= 0 && there(flat) && there(colors) && (!is_signed || there(rests)) && there(parts);
    }
};

/// One row of each part; one thread uses it throughout its life.
struct AtlasRowPlanes {
    PackedRows::Row flat, words, parts;
};

template <class Value>
Value value_of(const PackedRows::Row& row, int plane, std::size_t sample) {
    return row.value<Value>(static_cast<std::size_t>(plane), sample);
}

float half_of(const PackedRows::Row& row, int plane, std::size_t sample) {
    return imath_half_to_float(value_of<std::uint16_t>(row, plane, sample));
}

}  // namespace

struct AtlasFile::Impl {
    Impl(std::string file_path, std::unique_ptr<PackedRows> of_flat, std::unique_ptr<PackedRows> of_path_strings,
         std::unique_ptr<PackedRows> of_parts)
        : path(std::move(file_path)),
          flat(std::move(of_flat)),
          words(std::move(of_path_strings)),
          parts(std::move(of_parts)),
          planes(*flat, *words, *parts) {}

    Status take_path_strings(const AtlasRowPlanes& from, AtlasRow& row) const;
    Status take_parts(const AtlasRowPlanes& from, AtlasRow& row) const;
    void take_flat(const AtlasRowPlanes& from, AtlasRow& row) const;
    [[nodiscard]] Error damaged(const std::string& what) const {
        return error_at({path, 0, 0}, "the atlas is truncated or damaged: " + what);
    }

    std::string path;
    std::unique_ptr<PackedRows> flat, words, parts;
    AtlasPlanes planes;
    int width = 0, height = 0, min_y = 0;
    bool wants_parts = true;
    PathStringTable table;
    ImageDescription description;
};

Status AtlasFile::Impl::take_path_strings(const AtlasRowPlanes& from, AtlasRow& row) const {
    const std::size_t known = table.words.size();
    row.begin.assign(from.words.begin().begin(), from.words.begin().end());
    row.samples.resize(from.words.sample_count());
    for (std::size_t i = 0; i < row.samples.size(); ++i) {
        PathStringSample& sample = row.samples[i];
        sample.word = value_of<std::uint32_t>(from.words, planes.word, i);
        if (sample.word >= known) return damaged("it uses a word that is not in its table");
        for (std::size_t c = 0; c < 3; ++c)
            sample.rgb[c] = static_cast<double>(value_of<float>(from.words, planes.colors[c], i));
    }
    for (std::size_t i = 0; table.is_signed() && i < row.samples.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            row.samples[i].rgb[c] += static_cast<double>(value_of<float>(from.words, planes.rests[c], i));
    return success();
}

Status AtlasFile::Impl::take_parts(const AtlasRowPlanes& from, AtlasRow& row) const {
    const Error differ = damaged("its parts 'words' and 'parts' have different samples");
    std::size_t spread = 0;
    for (std::size_t x = 0; x + 1 < row.begin.size(); ++x) {
        for (std::size_t i = row.begin[x]; i < row.begin[x + 1]; ++i) {
            std::array<float, PathAtlas::parts>& shares = row.samples[i].parts;
            shares.fill(0);
            const float eighth = half_of(from.words, planes.eighth, i);
            if (!(eighth >= 0 && eighth <= AtlasLayout::several_eighths))
                return damaged("it has a word with an invalid eighth");
            if (eighth >= AtlasLayout::several_eighths) {
                if (spread == from.parts.sample_count()) return differ;
                for (std::size_t k = 0; k < shares.size(); ++k)
                    shares[k] = half_of(from.parts, planes.parts[k], spread);
                ++spread;
            } else if (eighth >= 1) {
                shares[static_cast<std::size_t>(eighth) - 1] = 1;
            }
        }
        if (spread != from.parts.begin()[x + 1]) return differ;
    }
    return success();
}

void AtlasFile::Impl::take_flat(const AtlasRowPlanes& from, AtlasRow& row) const {
    row.rgba.resize(static_cast<std::size_t>(width));
    row.counts.resize(static_cast<std::size_t>(width));
    for (std::size_t x = 0; x < row.rgba.size(); ++x) {
        for (std::size_t c = 0; c < 4; ++c) row.rgba[x][c] = value_of<float>(from.flat, planes.flat[c], x);
        for (std::size_t k = 0; k < PathAtlas::parts; ++k)
            row.counts[x][k] = value_of<float>(from.flat, planes.flat[4 + k], x);
    }
}

AtlasFile::AtlasFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AtlasFile::~AtlasFile() = default;

Result<std::unique_ptr<AtlasFile>> AtlasFile::open(const std::string& path) {
    if (Status good = check_exr_file(path); !good) return good.error();
    try {
        const Imf::MultiPartInputFile file(path.c_str());
        std::array<std::unique_ptr<PackedRows>, 3> rows;
        std::array<const Imf::Header*, 3> headers{};
        for (std::size_t p = 0; p < rows.size(); ++p) {
            const int index = part_named(file, AtlasLayout::parts[p], p > 0);
            if (index < 0) return no_atlas(path);
            headers[p] = &file.header(index);
            if (headers[p]->dataWindow() != headers[0]->dataWindow()) return no_atlas(path);
            if (p == 1 && !headers[1]->findTypedAttribute<Imf::StringAttribute>("atlas/version")) return no_atlas(path);
        }
        auto table = read_table(header_strings(*headers[1]), path);
        if (!table) return table.error();
        const auto packed = PackedRows::open_file(path);
        if (!packed) return packed.error();
        for (std::size_t p = 0; p < rows.size(); ++p) {
            auto of_part = PackedRows::open(*packed, part_named(file, AtlasLayout::parts[p], p > 0));
            if (!of_part) return of_part.error();
            rows[p] = *std::move(of_part);
        }
        auto impl = std::make_unique<Impl>(path, std::move(rows[0]), std::move(rows[1]), std::move(rows[2]));
        if (!impl->planes.are_all(table->is_signed())) return no_atlas(path);
        const Imath::Box2i& window = headers[0]->dataWindow();
        impl->width = window.max.x - window.min.x + 1;
        impl->height = window.max.y - window.min.y + 1;
        impl->min_y = window.min.y;
        impl->table = *std::move(table);
        read_description(*headers[0], impl->description);
        return std::unique_ptr<AtlasFile>(new AtlasFile(std::move(impl)));
    } catch (const std::exception& exception) {
        return error_at({path, 0, 0}, std::string("cannot read the atlas: ") + exception.what());
    }
}

int AtlasFile::width() const {
    return impl_->width;
}
int AtlasFile::height() const {
    return impl_->height;
}
const PathStringTable& AtlasFile::table() const {
    return impl_->table;
}
void AtlasFile::read_parts(bool wanted) {
    impl_->wants_parts = wanted;
}
const ImageDescription& AtlasFile::description() const {
    return impl_->description;
}
const std::string& AtlasFile::path() const {
    return impl_->path;
}

Status AtlasFile::row(int y, AtlasRow& row) {
    const Impl& impl = *impl_;
    const int line = impl.min_y + y;
    thread_local AtlasRowPlanes planes;
    if (Status read = impl.flat->read(line, planes.flat); !read) return read;
    if (Status read = impl.words->read(line, planes.words); !read) return read;
    impl.take_flat(planes, row);
    if (Status taken = impl.take_path_strings(planes, row); !taken) return taken;
    if (!impl.wants_parts) return success();
    if (Status read = impl.parts->read(line, planes.parts); !read) return read;
    return impl.take_parts(planes, row);
}

bool is_atlas(const std::string& path) {
    if (!check_exr_file(path)) return false;
    try {
        const Imf::MultiPartInputFile file(path.c_str());
        for (int i = 0; i < file.parts(); ++i)
            if (file.header(i).findTypedAttribute<Imf::StringAttribute>("atlas/version") != nullptr) return true;
    } catch (const std::exception&) { return false; }
    return false;
}

}  // namespace raylex::display
