// A small synthetic atlas for tests.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "display/output/atlas/atlas_file.h"
#include "lpe/match.h"

namespace raylex::test {

/// Words and light computed from the pixel's position. Row 1 has none, and row 2 has none from several eighths.
class MadeAtlas final : public display::AtlasSource {
  public:
    static constexpr int columns = 5, rows = 4;
    static constexpr std::uint32_t words = 12;
    explicit MadeAtlas(display::SignedLight negative) {
        table_.negative = negative;
        table_.events = *lpe::parse_events("R,D,floor V,-,fog L,-,key O,-");
        for (lpe::Event& event : table_.events)
            event.labels.resize(event.type == lpe::EventType::reflection || event.type == lpe::EventType::volume ? 2
                                                                                                                 : 1);
        table_.letters = {0, 1, 2, 3};
        for (std::uint32_t word = 0; word < words; ++word) {
            std::vector<display::PathStringTable::Letter> letters;
            for (std::uint32_t bits = word / 2; bits > 0; bits /= 2)
                letters.push_back(static_cast<display::PathStringTable::Letter>(bits % 2));
            letters.push_back(word % 2 == 0 ? 2 : 3);
            table_.words.push_back(std::move(letters));
        }
    }
    [[nodiscard]] int width() const override { return columns; }
    [[nodiscard]] int height() const override { return rows; }
    [[nodiscard]] const display::PathStringTable& table() const override { return table_; }
    Status row(int y, display::AtlasRow& row) override {
        row.begin.assign(1, 0);
        row.samples.clear();
        row.rgba.assign(columns, {});
        row.counts.assign(columns, {});
        for (int x = 0; x < columns; ++x) {
            const auto column = static_cast<std::size_t>(x);
            row.counts[column].fill(static_cast<float>(x + 1));
            const int count = y == 1 ? 0 : (3 * x + y) % 5;
            for (int n = 0; n < count; ++n) {
                display::PathStringSample sample;
                sample.word = static_cast<std::uint32_t>((5 * n + x) % static_cast<int>(words));
                const double light =
                    table_.is_signed() ? -1.0 / (n + 3) : static_cast<double>(0.125f * static_cast<float>(n + x));
                sample.rgb = {light, 2 * light, 0.5 * light};
                if (y == 2 || n % 2 == 0) sample.parts[static_cast<std::size_t>(n + y) % 8] = 1;
                else sample.parts = {0.25f, 0, 0, 0.5f, 0, 0, 0, 0.25f};
                row.samples.push_back(sample);
            }
            std::sort(
                row.samples.begin() + row.begin.back(), row.samples.end(),
                [](const display::PathStringSample& a, const display::PathStringSample& b) { return a.word < b.word; });
            row.begin.push_back(static_cast<std::uint32_t>(row.samples.size()));
            row.rgba[column] = {static_cast<float>(x), static_cast<float>(y), 0.5f, 1};
        }
        return success();
    }

  private:
    display::PathStringTable table_;
};

}  // namespace raylex::test
