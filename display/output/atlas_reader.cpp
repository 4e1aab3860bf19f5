#include <algorithm>
#include <exception>
#include <stdexcept>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputPart.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include "display/output/atlas_layout.h"
#include "display/output/atlas_table.h"
#include "display/output/exr_guard.h"
#include "display/output/exr_header.h"

namespace raylex::display {
namespace {

constexpr int atlas_rows_read = 32;
/// A damaged count must not ask for memory that no band of rows needs.
constexpr std::size_t most_band_samples = std::size_t{1} << 28;

std::map<std::string, std::string> header_strings(const Imf::Header& header) {
    std::map<std::string, std::string> strings;
    for (auto i = header.begin(); i != header.end(); ++i)
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute()))
            strings[i.name()] = text->value();
    return strings;
}

Error atlas_error(const std::string& path, const std::string& message) {
    Error error;
    error.file = path;
    error.message = message;
    return error;
}

Error no_atlas(const std::string& path) {
    return atlas_error(path,
                       "this is no path atlas: it has no parts 'rgba', 'words' and 'parts' as raylex render "
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

/// A new frame buffer makes OpenEXR forget the counts that it read for the last one.
void read_deep(Imf::DeepScanLineInputPart& part, const Imf::DeepFrameBuffer& buffer, int first, int last) {
    part.setFrameBuffer(buffer);
    part.readPixelSampleCounts(first, last);
    part.readPixels(first, last);
}

}  // namespace

struct AtlasFile::Impl {
    explicit Impl(const std::string& file_path)
        : path(file_path),
          file(file_path.c_str()),
          indices{part_named(file, AtlasLayout::parts[0], false), part_named(file, AtlasLayout::parts[1], true),
                  part_named(file, AtlasLayout::parts[2], true)} {}

    void read_band(int y);
    void read_flat(int first, int last);
    void read_counts(Imf::DeepScanLineInputPart& part, int first, int last, std::vector<std::size_t>& to);
    void read_words(int first, int last);
    void read_parts(int first, int last);
    void parts_of(std::size_t sample, std::array<float, PathAtlas::parts>& shares) const;
    template <class Value>
    void insert(Imf::DeepFrameBuffer& buffer, const std::vector<std::size_t>& places, const std::string& name,
                Imf::PixelType type, std::vector<Value>& values);
    [[nodiscard]] Imf::DeepFrameBuffer with_counts();
    [[nodiscard]] std::ptrdiff_t before() const { return std::ptrdiff_t{band_begin} * width + min_x; }

    std::string path;
    Imf::MultiPartInputFile file;
    std::array<int, 3> indices;
    int width = 0, height = 0, min_x = 0, min_y = 0;
    bool wants_parts = true;
    WordTable table;
    ImageDescription description;
    // The rows [band_begin, band_end) of the file.
    int band_begin = 0, band_end = 0;
    std::vector<unsigned> counts;
    std::vector<std::size_t> begin, spread_begin;  // [pixel + 1] of part `words`, of part `parts`
    std::vector<std::uint32_t> words;
    std::vector<float> eighths;
    std::vector<std::size_t> place_in_parts;  // [word sample] where several eighths brought light
    std::array<std::vector<float>, 3> colors, rests;
    std::array<std::vector<float>, PathAtlas::parts> parts;
    std::vector<float> flat;
    std::vector<std::vector<char*>> pointers;
};

Imf::DeepFrameBuffer AtlasFile::Impl::with_counts() {
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data() - before()),
                                             sizeof(unsigned), sizeof(unsigned) * static_cast<std::size_t>(width)));
    return buffer;
}

template <class Value>
void AtlasFile::Impl::insert(Imf::DeepFrameBuffer& buffer, const std::vector<std::size_t>& places,
                             const std::string& name, Imf::PixelType type, std::vector<Value>& values) {
    values.resize(places.back() + 1);  // pointers of pixels without samples must point somewhere, too
    std::vector<char*>& to = pointers.emplace_back();
    for (std::size_t pixel = 0; pixel + 1 < places.size(); ++pixel)
        to.push_back(reinterpret_cast<char*>(values.data() + places[pixel]));
    buffer.insert(name, Imf::DeepSlice(type, reinterpret_cast<char*>(to.data() - before()), sizeof(char*),
                                       sizeof(char*) * static_cast<std::size_t>(width), sizeof(Value)));
}

void AtlasFile::Impl::read_counts(Imf::DeepScanLineInputPart& part, int first, int last, std::vector<std::size_t>& to) {
    part.setFrameBuffer(with_counts());
    part.readPixelSampleCounts(first, last);
    to.assign(1, 0);
    for (const unsigned count : counts) {
        to.push_back(to.back() + count);
        if (to.back() > most_band_samples) throw std::runtime_error("its rows claim more samples than any atlas has");
    }
}

void AtlasFile::Impl::read_words(int first, int last) {
    Imf::DeepScanLineInputPart part(file, indices[1]);
    read_counts(part, first, last, begin);
    Imf::DeepFrameBuffer buffer = with_counts();
    insert(buffer, begin, AtlasLayout::word, Imf::UINT, words);
    if (wants_parts) insert(buffer, begin, AtlasLayout::eighth, Imf::FLOAT, eighths);
    for (std::size_t c = 0; c < 3; ++c) insert(buffer, begin, AtlasLayout::colors[c], Imf::FLOAT, colors[c]);
    for (std::size_t c = 0; table.is_signed() && c < 3; ++c)
        insert(buffer, begin, AtlasLayout::rests[c], Imf::FLOAT, rests[c]);
    read_deep(part, buffer, first, last);
    const std::size_t known = table.words.size();
    for (std::size_t i = 0; i < begin.back(); ++i)
        if (words[i] >= known) throw std::runtime_error("it names a word that its table does not have");
}

void AtlasFile::Impl::read_parts(int first, int last) {
    Imf::DeepScanLineInputPart part(file, indices[2]);
    read_counts(part, first, last, spread_begin);
    place_in_parts.assign(begin.back(), 0);
    std::size_t spread = 0;
    for (std::size_t pixel = 0; pixel + 1 < begin.size(); ++pixel) {
        for (std::size_t i = begin[pixel]; i < begin[pixel + 1]; ++i) {
            if (!(eighths[i] >= 0 && eighths[i] <= AtlasLayout::several_eighths))
                throw std::runtime_error("it has a word of an eighth that there is not");
            if (eighths[i] == AtlasLayout::several_eighths) place_in_parts[i] = spread++;
        }
        if (spread != spread_begin[pixel + 1])
            throw std::runtime_error("its parts 'words' and 'parts' differ in their samples");
    }
    Imf::DeepFrameBuffer buffer = with_counts();
    for (std::size_t k = 0; k < PathAtlas::parts; ++k)
        insert(buffer, spread_begin, AtlasLayout::part(k), Imf::FLOAT, parts[k]);
    read_deep(part, buffer, first, last);
}

void AtlasFile::Impl::parts_of(std::size_t sample, std::array<float, PathAtlas::parts>& shares) const {
    const auto eighth = static_cast<std::uint32_t>(eighths[sample]);
    shares.fill(0);
    if (eighth == AtlasLayout::several_eighths)
        for (std::size_t k = 0; k < PathAtlas::parts; ++k) shares[k] = parts[k][place_in_parts[sample]];
    else if (eighth != AtlasLayout::no_luminance) shares[eighth - 1] = 1;
}

void AtlasFile::Impl::read_flat(int first, int last) {
    const std::vector<std::string> planes = AtlasLayout::flat_planes();
    flat.resize(planes.size() * counts.size());
    const std::size_t pixel = planes.size() * sizeof(float);
    Imf::InputPart part(file, indices[0]);
    Imf::FrameBuffer buffer;
    for (std::size_t p = 0; p < planes.size(); ++p)
        buffer.insert(planes[p], Imf::Slice(Imf::FLOAT,
                                            reinterpret_cast<char*>(flat.data() + p) -
                                                before() * static_cast<std::ptrdiff_t>(pixel),
                                            pixel, pixel * static_cast<std::size_t>(width)));
    part.setFrameBuffer(buffer);
    part.readPixels(first, last);
}

/// The band that begins with row `y` of the image.
void AtlasFile::Impl::read_band(int y) {
    const int first = min_y + y, last = min_y + std::min(y + atlas_rows_read, height) - 1;
    band_begin = first;
    band_end = last + 1;
    pointers.clear();
    counts.assign(static_cast<std::size_t>(last - first + 1) * static_cast<std::size_t>(width), 0);
    read_words(first, last);
    if (wants_parts) read_parts(first, last);
    read_flat(first, last);
}

AtlasFile::AtlasFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
AtlasFile::~AtlasFile() = default;

Result<std::unique_ptr<AtlasFile>> AtlasFile::open(const std::string& path) {
    if (Status good = check_exr_file(path); !good) return good.error();
    try {
        start_encoder_threads();
        auto impl = std::make_unique<Impl>(path);
        const auto& indices = impl->indices;
        if (std::any_of(indices.begin(), indices.end(), [](int index) { return index < 0; })) return no_atlas(path);
        const Imf::Header& words = impl->file.header(indices[1]);
        const Imath::Box2i& window = words.dataWindow();
        for (const int index : indices)
            if (impl->file.header(index).dataWindow() != window) return no_atlas(path);
        impl->width = window.max.x - window.min.x + 1;
        impl->height = window.max.y - window.min.y + 1;
        impl->min_x = window.min.x;
        impl->min_y = window.min.y;
        auto table = read_table(header_strings(words), path);
        if (!table) return table.error();
        impl->table = *std::move(table);
        read_description(impl->file.header(indices[0]), impl->description);
        return std::unique_ptr<AtlasFile>(new AtlasFile(std::move(impl)));
    } catch (const std::exception& exception) {
        return atlas_error(path, std::string("cannot read the atlas: ") + exception.what());
    }
}

int AtlasFile::width() const {
    return impl_->width;
}
int AtlasFile::height() const {
    return impl_->height;
}
const WordTable& AtlasFile::table() const {
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
    Impl& impl = *impl_;
    const int line = impl.min_y + y;
    try {
        if (line < impl.band_begin || line >= impl.band_end) impl.read_band(y);
    } catch (const std::exception& exception) {
        impl.band_begin = impl.band_end = 0;
        return atlas_error(impl.path, std::string("the atlas is truncated or damaged: ") + exception.what());
    }
    const auto width = static_cast<std::size_t>(impl.width);
    const std::size_t first = static_cast<std::size_t>(line - impl.band_begin) * width;
    row.begin.assign(1, 0);
    row.rgba.resize(width);
    row.counts.resize(width);
    for (std::size_t x = 0; x < width; ++x) {
        row.begin.push_back(static_cast<std::uint32_t>(impl.begin[first + x + 1] - impl.begin[first]));
        const float* const flat = impl.flat.data() + (first + x) * (4 + PathAtlas::parts);
        std::copy_n(flat, 4, row.rgba[x].begin());
        std::copy_n(flat + 4, PathAtlas::parts, row.counts[x].begin());
    }
    row.samples.resize(row.begin.back());
    for (std::size_t i = 0; i < row.samples.size(); ++i) {
        const std::size_t at = impl.begin[first] + i;
        WordSample& sample = row.samples[i];
        sample.word = impl.words[at];
        for (std::size_t c = 0; c < 3; ++c) sample.rgb[c] = static_cast<double>(impl.colors[c][at]);
        for (std::size_t c = 0; impl.table.is_signed() && c < 3; ++c)
            sample.rgb[c] += static_cast<double>(impl.rests[c][at]);
        if (impl.wants_parts) impl.parts_of(at, sample.parts);
    }
    return success();
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
