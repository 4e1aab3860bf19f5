// Writes a set of event classes as one item of a `renderman` expression: `D`, `[DS]`, `<R[^D2]>`, `<L.[^'key''fill']>`.
//
// The set is a table over four slots (type, lobe, first label, second label). Boxes cover the table; each box is a set
// of values per slot and becomes one <...>. The shorter of the cover and the excluding form [^...] is used. Events that
// cannot occur where the item occurs are free: a box can contain them or not, whichever is shorter.
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

/// The labels that expressions name, by slot: object or light group, then lobe.
struct SlotLabels {
    std::array<std::vector<std::string>, 2> names, globs;
    bool deeper = false;  ///< an expression tests a third label, which the four slots cannot represent

    /// Adds the labels that the tree names.
    void gather(const Node& root);
};

class EventWriter {
  public:
    /// `extensions`: the writer can use the letters B, V and G, which RenderMan does not support. Throws Failure when
    /// there are too many labels for the table.
    EventWriter(const EventClasses& classes, const SlotLabels& labels, bool extensions = true);

    /// An item that matches every class of `wanted` and no class of `avoided`; nothing if one item cannot express this.
    [[nodiscard]] std::optional<std::string> write(const ClassSet& wanted, const ClassSet& avoided) const;
    /// An item for events that also carry the first label `label`, written as "'floor'" or "[^'floor''wall']". `wanted`
    /// and `avoided` must not depend on labels. If several items are needed, the result has no brackets around them.
    [[nodiscard]] std::optional<std::string> write_labelled(const ClassSet& wanted, const ClassSet& avoided,
                                                            const std::string& label) const;

  private:
    static constexpr std::size_t slots = 4;  // type, lobe, first label, second label
    using Values = std::vector<bool>;        // values of one slot
    using Box = std::array<Values, slots>;
    enum class Cell : std::uint8_t { avoided, wanted, free };

    /// The text of a set of values of a slot.
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
    std::vector<EventClass> class_of_cell_;  // no_class for cells without an event of W
};

}  // namespace raylex::lpe
