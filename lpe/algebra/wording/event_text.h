// Sets of events as people write them: a set of event classes becomes one item of a `renderman` expression, `D`,
// `[DS]`,
// `<R[^D2]>`, `<L.[^'key''fill']>`.
//
// The set is seen as a table over four slots (type, lobe, first label, second label). It is covered by boxes, each a
// set of values a slot, and a box is a <...>; of the cover and the excluding form [^...] the shorter is taken. Events
// that cannot stand where the item will stand are free: a box may hold them or not, whatever is shorter.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lpe/language/ast.h"
#include "lpe/language/event_classes.h"

namespace raylex::lpe {

/// The labels that expressions name, slot by slot: object or light group, then lobe.
struct SlotLabels {
    std::array<std::vector<std::string>, 2> names, globs;
    bool deeper = false;  ///< some expression tests a third label, which sets of events cannot show

    /// Adds what the tree names.
    void gather(const Node& root);
};

class EventWriter {
  public:
    /// Throws Failure when the labels are too many to lay out. `extensions`: the letters B, V and G may be written,
    /// which RenderMan does not know.
    EventWriter(const EventClasses& classes, const SlotLabels& labels, bool extensions = true);

    /// An item that matches every class of `wanted` and none of `avoided`; nothing where only a longer construction
    /// could.
    [[nodiscard]] std::optional<std::string> write(const ClassSet& wanted, const ClassSet& avoided) const;
    /// The same for the events that also carry a first label: `label` is its text, "'floor'" or "[^'floor''wall']". The
    /// sets say nothing of labels then. Several items come without brackets around them.
    [[nodiscard]] std::optional<std::string> write_labelled(const ClassSet& wanted, const ClassSet& avoided,
                                                            const std::string& label) const;

  private:
    static constexpr std::size_t slots = 4;  // type, lobe, first label, second label
    using Values = std::vector<bool>;        // of one slot
    using Box = std::array<Values, slots>;
    enum class Cell : std::uint8_t { avoided, wanted, free };

    /// A text that stands for some values of a slot.
    struct Letter {
        std::string text;
        Values values;
    };

    [[nodiscard]] std::size_t index(const std::array<std::size_t, slots>& at) const;
    [[nodiscard]] std::vector<Cell> table(const ClassSet& wanted, const ClassSet& avoided) const;
    [[nodiscard]] bool fits(const std::vector<Cell>& cells, const Box& box) const;
    [[nodiscard]] Box grown(const std::vector<Cell>& cells, const std::array<std::size_t, slots>& from,
                            const std::array<std::size_t, slots>& order) const;
    [[nodiscard]] bool holds(const Box& box, std::size_t cell) const;
    [[nodiscard]] std::optional<Box> best_box(const std::vector<Cell>& cells, const std::vector<Cell>& left,
                                              std::size_t cell) const;
    [[nodiscard]] std::optional<std::vector<std::string>> texts(const std::vector<Cell>& cells,
                                                                const std::vector<Box>& boxes,
                                                                const std::string& label) const;
    [[nodiscard]] std::optional<std::vector<std::string>> cover(const std::vector<Cell>& cells,
                                                                const std::string& label = {}) const;
    [[nodiscard]] Values values_in_use(const std::vector<Cell>& cells, const Box& box, std::size_t slot) const;
    [[nodiscard]] std::optional<std::vector<std::string>> box_text(const std::vector<Cell>& cells, const Box& box,
                                                                   const std::string& label = {}) const;

    void add_types(bool extensions);
    void add_lobes(bool extensions);
    void add_labels(std::size_t slot, const std::vector<std::string>& names, const std::vector<std::string>& globs);

    std::array<std::size_t, slots> sizes_{};
    std::array<std::vector<Letter>, slots> letters_;
    std::array<std::vector<std::string>, 2> label_examples_;
    std::vector<EventClass> class_of_cell_;  // no_class where no event of W is such
};

}  // namespace raylex::lpe
