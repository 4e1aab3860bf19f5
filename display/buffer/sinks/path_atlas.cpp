#include "display/buffer/sinks/path_atlas.h"

#include <algorithm>
#include <cmath>

#include "display/buffer/raster_footprint.h"
#include "display/buffer/sinks/path_atlas_pixel.h"
#include "display/services/samples/batch_path_strings.h"
#include "display/services/split_mix.h"

namespace raylex::display {
namespace {

constexpr int quantum_exponent = FrameBufferLayout().quantum_exponent;
constexpr int block_size = FrameBufferLayout().block_size;
using Sums = std::array<double, 3 + PathAtlas::parts>;

std::size_t part_of(const CameraRow& row) {
    return static_cast<std::size_t>(row.sample % PathAtlas::parts);
}

}  // namespace

/// The exact sums of the words of a batch, block by block, before rounding. Used by one thread.
class PathAtlas::Batch {
  public:
    struct Sum {
        std::uint64_t key = 0;  ///< block and word
        Sums light{};
    };
    void begin() {
        sums_.clear();
        ++epoch_;
        if (slots_.empty()) slots_.resize(1024);
    }
    Sums& of(std::uint32_t block, std::uint32_t word) {
        const std::uint64_t key = (std::uint64_t{block} << 32) | word;
        std::size_t mask = slots_.size() - 1, at = mix_bits(key) & mask;
        for (; slots_[at].epoch == epoch_; at = (at + 1) & mask)
            if (sums_[slots_[at].place].key == key) return sums_[slots_[at].place].light;
        slots_[at] = {epoch_, static_cast<std::uint32_t>(sums_.size())};
        sums_.push_back({key, {}});
        if (2 * sums_.size() > slots_.size()) grow();
        return sums_.back().light;
    }
    [[nodiscard]] std::span<const Sum> sums() const { return sums_; }

    std::vector<std::uint32_t> block_of;  ///< [camera row] index into block_pixel
    std::vector<std::size_t> block_pixel;

  private:
    struct Slot {
        std::uint64_t epoch = 0;
        std::uint32_t place = 0;
    };
    void grow() {
        slots_.assign(2 * slots_.size(), {});
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t i = 0; i < sums_.size(); ++i) {
            std::size_t at = mix_bits(sums_[i].key) & mask;
            while (slots_[at].epoch == epoch_) at = (at + 1) & mask;
            slots_[at] = {epoch_, static_cast<std::uint32_t>(i)};
        }
    }
    std::vector<Sum> sums_;
    std::vector<Slot> slots_;
    std::uint64_t epoch_ = 0;
};

PathAtlas::PathAtlas(const Settings& settings)
    : settings_(settings),
      pixels_(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height)),
      pools_(std::make_unique<Pools>(quantum_exponent + settings.scale_exponent)),
      merged_into_(1, PathStringTree::root) {}

PathAtlas::~PathAtlas() = default;

/// Finds the atlas's number of a word. New words become ever rarer, and only they make threads wait for each other.
std::uint32_t PathAtlas::known_as(BatchPathStrings& words, std::uint32_t word) {
    constexpr std::uint32_t unknown = 0;  // the camera alone is not a word
    if (word < words.known_as.size() && words.known_as[word] != unknown) return words.known_as[word];
    const std::lock_guard lock(path_strings_mutex_);
    std::uint32_t known = PathStringTree::root;
    for (const PathStringTree::Letter letter : words.words().letters(word)) known = words_.child(known, letter);
    for (auto next = static_cast<std::uint32_t>(merged_into_.size()); next < words_.size(); ++next)
        merged_into_.push_back(next);
    known = survivor(known);
    words.known_as.resize(std::max<std::size_t>(words.known_as.size(), words.words().size()), unknown);
    words.known_as[word] = known;
    return known;
}

/// Before a batch: exchanges new events and merges between the words and the atlas.
void PathAtlas::note_events(BatchPathStrings& words) {
    if (words.atlas_generation != generation_) words.known_as.clear();
    words.atlas_generation = generation_;
    if (!words.take_news()) return;
    const std::lock_guard lock(path_strings_mutex_);
    seen_.resize(words.seen().size(), 0);
    for (std::size_t column = 0; column < seen_.size(); ++column) seen_[column] |= words.seen()[column];
    dropped_straight_ = dropped_straight_ || words.dropped_straight();
}

std::uint32_t PathAtlas::survivor(std::uint32_t word) const {
    while (merged_into_[word] != word) word = merged_into_[word];
    return word;
}

/// The stored sums depend on `light` alone. Light of a single eighth is added as R + G + B were, so the eighth is still
/// exact when a second eighth is added (Law 3). The frame buffer rejects and counts sums out of range.
void PathAtlas::add(std::size_t pixel, std::uint32_t word, const Sums& light, Reserves& reserves) {
    if (std::all_of(light.begin(), light.end(), [](double each) { return each == 0; })) return;
    std::uint32_t lit = 0, last = 0;
    for (std::uint32_t k = 0; k < parts; ++k) {
        if (light[3 + k] == 0) continue;
        ++lit;
        last = k + 1;
    }
    Pixel& of = pixels_[pixel];
    Slot* known = of.find(word);
    if (known == nullptr && lit == 1) {
        const std::uint32_t single = reserves.singles.take();
        reserves.singles[single] = {{light[0], light[1], light[2]}, word, last};
        of.insert({word, single | Slot::of_single}, reserves.slots);
        return;
    }
    if (known == nullptr) {
        const std::uint32_t number = reserves.entries.take();
        reserves.entries[number].word = word;
        known = &of.insert({word, number}, reserves.slots);
    }
    Entry& entry = reserves.entry(*known);
    const bool of_one = lit == 1 && (entry.eighth == Entry::no_eighth || entry.eighth == last);
    if (of_one) entry.eighth = last;
    else reserves.spread(entry);
    Int128 all = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        Int128 term = 0;
        if (light[c] == 0 || !to_fixed(light[c], reserves.exponent, term) || !add_fixed(entry.light[c], term)) continue;
        static_cast<void>(add_fixed(all, term));
    }
    if (!entry.is_spread()) return;
    for (std::uint32_t k = 0; k < parts; ++k) {
        Int128 term = all;
        if (light[3 + k] != 0 && (lit == 1 || to_fixed(light[3 + k], reserves.exponent, term)))
            static_cast<void>(add_fixed(reserves.eighths[entry.eighths].sums[k], term));
    }
}

void PathAtlas::accumulate(const SampleTable& table) {
    BatchPathStrings* const words = table.words();
    if (words == nullptr || table.discarded()) return;
    note_events(*words);
    thread_local Batch batch;
    batch.begin();
    batch.block_of.clear();
    batch.block_pixel.clear();
    constexpr auto outside = ~std::size_t{0};
    for (int row = 0; row < table.camera_row_count(); ++row) {
        const CameraRow& camera = table.camera_row(row);
        const bool inside = camera.pixel_x >= 0 && camera.pixel_y >= 0 && camera.pixel_x < settings_.width &&
                            camera.pixel_y < settings_.height;
        const std::size_t pixel =
            inside ? static_cast<std::size_t>(camera.pixel_y) * static_cast<std::size_t>(settings_.width) +
                         static_cast<std::size_t>(camera.pixel_x)
                   : outside;
        const bool same_block = row > 0 && batch.block_pixel.back() == pixel &&
                                camera.sample / block_size == table.camera_row(row - 1).sample / block_size;
        if (!same_block) batch.block_pixel.push_back(pixel);
        batch.block_of.push_back(static_cast<std::uint32_t>(batch.block_pixel.size() - 1));
        if (!inside) continue;
        Int128 weight = 0;
        if (to_fixed(static_cast<double>(camera.filter_weight), quantum_exponent, weight))
            static_cast<void>(add_fixed(pixels_[pixel].weight, weight));
        ++pixels_[pixel].samples[part_of(camera)];
    }
    for (const BatchPathStrings::Entry& entry : words->entries()) {
        const auto row = static_cast<std::size_t>(table.original(static_cast<int>(entry.row)));
        const CameraRow& camera = table.camera_row(static_cast<int>(row));
        const double weight = static_cast<double>(camera.filter_weight);
        Sums& sum = batch.of(batch.block_of[row], known_as(*words, entry.word));
        const double r = entry.r * weight, g = entry.g * weight, b = entry.b * weight;
        sum[0] += r;
        sum[1] += g;
        sum[2] += b;
        sum[3 + part_of(camera)] += r + g + b;
    }
    Reserves reserves(*pools_);
    const std::span<const Batch::Sum> sums = batch.sums();
    const auto pixel_of = [&](std::size_t i) { return batch.block_pixel[sums[i].key >> 32]; };
    const auto path_string_of = [&](std::size_t i) { return 2 * static_cast<std::uint32_t>(sums[i].key); };
    const auto with_pixel = [&](std::size_t i, auto function) {
        if (i < sums.size() && pixel_of(i) != outside) function(pixels_[pixel_of(i)], path_string_of(i));
    };
    constexpr std::size_t ahead = 8;
    for (std::size_t i = 0; i < sums.size(); ++i) {
        with_pixel(i + 2 * ahead, [](const Pixel& of, std::uint32_t word) { of.prefetch_slot(word); });
        with_pixel(i + ahead, [&](const Pixel& of, std::uint32_t word) { of.prefetch_entry(word, *pools_); });
        if (pixel_of(i) != outside) add(pixel_of(i), path_string_of(i), sums[i].light, reserves);
    }
}

void PathAtlas::splat(const SampleTable& table, std::span<const int> rows) {
    BatchPathStrings* const words = table.words();
    if (words == nullptr || settings_.raster == nullptr) return;
    note_events(*words);
    Reserves reserves(*pools_);
    // Entries of a row are in the order of contributions, and rows are in the same order.
    const std::span<const BatchPathStrings::Entry> entries = words->entries();
    for (const int row : rows) {
        const auto of_row = static_cast<std::uint32_t>(row);
        auto first =
            std::lower_bound(entries.begin(), entries.end(), of_row,
                             [](const BatchPathStrings::Entry& entry, std::uint32_t r) { return entry.row < r; });
        const CameraRow& where = table.camera_row(row);
        for (; first != entries.end() && first->row == of_row; ++first) {
            const std::uint32_t word = known_as(*words, first->word);
            for_each_reached(*settings_.raster, where, settings_.width, settings_.height,
                             [&](std::size_t pixel, double weight) {
                                 Sums light{weight * first->r, weight * first->g, weight * first->b};
                                 light[3 + part_of(where)] = light[0] + light[1] + light[2];
                                 add(pixel, 2 * word + 1, light, reserves);
                             });
        }
    }
}

void PathAtlas::resolve(std::size_t pixel, std::uint64_t light_paths, std::vector<Light>& words) const {
    words.clear();
    const Pixel& of = pixels_[pixel];
    std::uint64_t count = 0;
    for (const std::uint32_t samples : of.samples) count += samples;
    // The rule of the frame buffer: if weights cancel, the divisor is the sample count.
    const long double weight = to_long_double(of.weight, quantum_exponent);
    const long double divisor = weight != 0 ? weight : static_cast<long double>(count);
    const long double by_samples = divisor != 0 ? 1 / divisor : 0;
    const long double by_paths =
        light_paths == 0 ? 0 : static_cast<long double>(pixels_.size()) / static_cast<long double>(light_paths);
    of.for_each(*pools_, [&](const Entry& entry) {
        const long double scale = (entry.word & 1) != 0 ? by_paths : by_samples;
        Light light;
        light.word = entry.word >> 1;
        const auto value = [&](Int128 sum) {
            return static_cast<double>(to_long_double(sum, pools_->exponent) * scale);
        };
        for (std::size_t c = 0; c < 3; ++c) light.rgb[c] = value(entry.light[c]);
        entry.for_each_eighth(pools_->eighths, [&](std::uint32_t k, Int128 sum) { light.eighths[k] = value(sum); });
        words.push_back(light);
    });
    if (settings_.raster == nullptr) return;
    std::sort(words.begin(), words.end(), [](const Light& a, const Light& b) { return a.word < b.word; });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (kept > 0 && words[kept - 1].word == words[i].word) {
            for (std::size_t c = 0; c < 3; ++c) words[kept - 1].rgb[c] += words[i].rgb[c];
            for (std::size_t k = 0; k < parts; ++k) words[kept - 1].eighths[k] += words[i].eighths[k];
        } else {
            words[kept++] = words[i];
        }
    }
    words.resize(kept);
}

std::span<const std::uint32_t, PathAtlas::parts> PathAtlas::samples(std::size_t pixel) const {
    return pixels_[pixel].samples;
}

std::size_t PathAtlas::expected_bytes() const {
    constexpr std::size_t likely_path_strings = 24;  // approximate number in the ready scenes
    constexpr std::size_t word = sizeof(Entry) + sizeof(Eighths) + 2 * sizeof(Slot);
    const std::uint64_t all = pixels_.size() * (sizeof(Pixel) + likely_path_strings * word);
    return static_cast<std::size_t>(settings_.budget > 0 ? std::min(all, settings_.budget) : all);
}

std::uint64_t PathAtlas::entry_count() const {
    return pools_->words();
}

std::uint64_t PathAtlas::memory_bytes() const {
    std::uint64_t bytes = words_.memory_bytes() + 4 * merged_into_.capacity();
    bytes += pools_->bytes();
    for (const Pixel& pixel : pixels_) bytes += pixel.bytes();
    return bytes;
}

std::vector<double> PathAtlas::light_of_path_strings() const {
    // The sums are exact, so the order of words with nearly equal light depends only on the light.
    std::vector<Int128> sums(words_.size(), 0);
    pools_->for_each([&](const Entry& entry) {
        for (const Int128 sum : entry.light) {
            sums[entry.word >> 1] += (sum < 0 ? -sum : sum) >> 24;  // leaves room for the largest sums of 2^24 pixels
        }
    });
    std::vector<double> light;
    for (const Int128 sum : sums) light.push_back(static_cast<double>(to_long_double(sum, pools_->exponent + 24)));
    return light;
}

}  // namespace raylex::display
