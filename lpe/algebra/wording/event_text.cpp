#include "lpe/algebra/wording/event_text.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "lpe/failure.h"
#include "lpe/language/glob.h"

namespace raylex::lpe {

namespace {

/// Cells of the table over all slots, enough for some seventy labels. More labels would give no short text.
constexpr std::size_t most_cells = 12'000;
constexpr std::size_t most_boxes = 24;  // of one item
constexpr EventClass no_class = 0xFFFF;

constexpr std::array<EventType, 7> types{EventType::camera,  EventType::reflection, EventType::transmission,
                                         EventType::volume,  EventType::light,      EventType::background,
                                         EventType::emission};

struct Lobe {
    Scatter scatter = Scatter::none;
    int number = 0;
};

/// All lobes: no scatter, D0 to D4, G0 to G8, S0 to S8.
const std::vector<Lobe>& lobes() {
    static const std::vector<Lobe> list = [] {
        std::vector<Lobe> all{{Scatter::none, 0}};
        for (int k = 0; k <= 4; ++k) { all.push_back({Scatter::diffuse, k}); }
        for (const Scatter scatter : {Scatter::glossy, Scatter::singular}) {
            for (int k = 0; k <= 8; ++k) { all.push_back({scatter, k}); }
        }
        return all;
    }();
    return list;
}

bool occurs(EventType type, const Lobe& lobe) {
    const bool surface = type == EventType::reflection || type == EventType::transmission;
    return surface == (lobe.scatter != Scatter::none);
}

std::string joined(const std::vector<std::string>& texts) {
    std::string all;
    for (const std::string& text : texts) { all += text; }
    return all;
}

/// A small set of letters, chosen greedily by size, that covers every value of `needed` and no value of `forbidden`.
template <class Letters>
std::optional<std::vector<std::string>> choose(const Letters& letters, const std::vector<bool>& needed,
                                               const std::vector<bool>& forbidden) {
    std::vector<bool> left = needed;
    std::vector<const typename Letters::value_type*> chosen;
    while (std::find(left.begin(), left.end(), true) != left.end()) {
        const typename Letters::value_type* best = nullptr;
        std::size_t most = 0;
        for (const auto& letter : letters) {
            std::size_t gain = 0;
            bool usable = true;
            for (std::size_t v = 0; v < left.size(); ++v) {
                usable = usable && !(letter.values[v] && forbidden[v]);
                gain += letter.values[v] && left[v] ? 1U : 0U;
            }
            if (usable && gain > most) {
                most = gain;
                best = &letter;
            }
        }
        if (best == nullptr) { return std::nullopt; }
        for (std::size_t v = 0; v < left.size(); ++v) { left[v] = left[v] && !best->values[v]; }
        chosen.push_back(best);
    }
    std::sort(chosen.begin(), chosen.end());  // order of the letters
    std::vector<std::string> texts;
    for (const auto* letter : chosen) { texts.push_back(letter->text); }
    return texts;
}

}  // namespace

void SlotLabels::gather(const Node& root) {
    const auto add = [](std::vector<std::string>& list, const std::vector<std::string>& more) {
        for (const std::string& each : more) {
            if (std::find(list.begin(), list.end(), each) == list.end()) { list.push_back(each); }
        }
    };
    for (const auto* patterns : {&root.events.any_of, &root.events.none_of}) {
        for (const EventPattern& pattern : *patterns) {
            for (std::size_t slot = 0; slot < pattern.labels.size(); ++slot) {
                if (slot >= names.size()) {
                    deeper = deeper || !pattern.labels[slot].is_any();
                    continue;
                }
                add(names[slot], pattern.labels[slot].names);
                add(globs[slot], pattern.labels[slot].globs);
            }
        }
    }
    for (const NodePtr& child : root.children) { gather(*child); }
}

EventWriter::EventWriter(const EventClasses& classes, const SlotLabels& labels, bool extensions) {
    add_types(extensions);
    add_lobes(extensions);
    add_labels(0, labels.names[0], labels.globs[0]);
    add_labels(1, labels.names[1], labels.globs[1]);
    if (sizes_[0] * sizes_[1] * sizes_[2] * sizes_[3] > most_cells) {
        fail("the expressions name too many labels to write the set as text");
    }
    class_of_cell_.assign(sizes_[0] * sizes_[1] * sizes_[2] * sizes_[3], no_class);
    for (std::size_t type = 0; type < sizes_[0]; ++type) {
        for (std::size_t lobe = 0; lobe < sizes_[1]; ++lobe) {
            if (!occurs(types[type], lobes()[lobe])) { continue; }
            Event event{types[type], lobes()[lobe].scatter, static_cast<std::uint8_t>(lobes()[lobe].number), {"", ""}};
            for (std::size_t a = 0; a < sizes_[2]; ++a) {
                for (std::size_t b = 0; b < sizes_[3]; ++b) {
                    event.labels[0] = label_examples_[0][a];
                    event.labels[1] = label_examples_[1][b];
                    class_of_cell_[index({type, lobe, a, b})] = classes.classify(event);
                }
            }
        }
    }
}

void EventWriter::add_types(bool extensions) {
    sizes_[0] = types.size();
    const auto add = [&](std::string text, std::initializer_list<EventType> meant) {
        Values values(types.size(), false);
        for (std::size_t k = 0; k < types.size(); ++k) {
            values[k] = std::find(meant.begin(), meant.end(), types[k]) != meant.end();
        }
        letters_[0].push_back({std::move(text), std::move(values)});
    };
    add("C", {EventType::camera});
    add("L", {EventType::light, EventType::background});
    add("O", {EventType::emission});
    if (extensions) { add("B", {EventType::background}); }
    add("R", {EventType::reflection});
    add("T", {EventType::transmission});
    if (extensions) { add("V", {EventType::volume}); }
}

void EventWriter::add_lobes(bool extensions) {
    sizes_[1] = lobes().size();
    const auto add = [&](std::string text, std::initializer_list<Scatter> scatters, int number) {
        Values values(lobes().size(), false);
        for (std::size_t k = 0; k < lobes().size(); ++k) {
            values[k] = std::find(scatters.begin(), scatters.end(), lobes()[k].scatter) != scatters.end() &&
                        (number == 0 || lobes()[k].number == number);
        }
        letters_[1].push_back({std::move(text), std::move(values)});
    };
    add("D", {Scatter::diffuse}, 0);
    add("S", {Scatter::glossy, Scatter::singular}, 0);
    if (extensions) { add("G", {Scatter::glossy}, 0); }
    for (int k = 1; k <= 4; ++k) { add("D" + std::to_string(k), {Scatter::diffuse}, k); }
    for (int k = 1; k <= 8; ++k) { add("S" + std::to_string(k), {Scatter::glossy, Scatter::singular}, k); }
}

void EventWriter::add_labels(std::size_t slot, const std::vector<std::string>& names,
                             const std::vector<std::string>& globs) {
    // One value for every name, and one for every kind of other labels.
    std::vector<std::string>& examples = label_examples_[slot];
    examples = names;
    for (LabelKind& kind : label_kinds(globs, names)) { examples.push_back(std::move(kind.example)); }
    sizes_[slot + 2] = examples.size();
    for (std::size_t k = 0; k < names.size(); ++k) {
        Values values(examples.size(), false);
        values[k] = true;
        letters_[slot + 2].push_back({quoted_label(names[k]), std::move(values)});
    }
    for (const std::string& glob : globs) {
        Values values(examples.size(), false);
        for (std::size_t k = 0; k < examples.size(); ++k) { values[k] = glob_matches(glob, examples[k]); }
        letters_[slot + 2].push_back({"'" + glob + "'", std::move(values)});
    }
}

std::size_t EventWriter::index(const std::array<std::size_t, slots>& at) const {
    return ((at[0] * sizes_[1] + at[1]) * sizes_[2] + at[2]) * sizes_[3] + at[3];
}

std::vector<EventWriter::Cell> EventWriter::table(const ClassSet& wanted, const ClassSet& avoided) const {
    std::vector<Cell> cells(class_of_cell_.size(), Cell::free);
    for (std::size_t k = 0; k < cells.size(); ++k) {
        const EventClass event_class = class_of_cell_[k];
        if (event_class != no_class) {
            cells[k] = wanted[event_class] ? Cell::wanted : avoided[event_class] ? Cell::avoided : Cell::free;
        }
    }
    return cells;
}

/// Returns whether the box contains no avoided cell.
bool EventWriter::fits(const std::vector<Cell>& cells, const Box& box) const {
    for (std::size_t a = 0; a < sizes_[0]; ++a) {
        for (std::size_t b = 0; box[0][a] && b < sizes_[1]; ++b) {
            for (std::size_t c = 0; box[1][b] && c < sizes_[2]; ++c) {
                for (std::size_t d = 0; box[2][c] && d < sizes_[3]; ++d) {
                    if (box[3][d] && cells[index({a, b, c, d})] == Cell::avoided) { return false; }
                }
            }
        }
    }
    return true;
}

/// Grows a box from one cell as far as possible, slot by slot in the given order.
EventWriter::Box EventWriter::grown(const std::vector<Cell>& cells, const std::array<std::size_t, slots>& from,
                                    const std::array<std::size_t, slots>& order) const {
    Box box;
    for (std::size_t slot = 0; slot < slots; ++slot) {
        box[slot].assign(sizes_[slot], false);
        box[slot][from[slot]] = true;
    }
    for (const std::size_t slot : order) {
        Values wide(sizes_[slot], false);
        for (std::size_t value = 0; value < sizes_[slot]; ++value) {
            Box one = box;
            one[slot].assign(sizes_[slot], false);
            one[slot][value] = true;
            wide[value] = fits(cells, one);
        }
        box[slot] = std::move(wide);
    }
    return box;
}

/// The values of a slot that the box needs to keep its wanted cells.
EventWriter::Values EventWriter::values_in_use(const std::vector<Cell>& cells, const Box& box, std::size_t slot) const {
    Values used(sizes_[slot], false);
    std::array<std::size_t, slots> at{};
    for (at[0] = 0; at[0] < sizes_[0]; ++at[0]) {
        for (at[1] = 0; at[1] < sizes_[1] && box[0][at[0]]; ++at[1]) {
            for (at[2] = 0; at[2] < sizes_[2] && box[1][at[1]]; ++at[2]) {
                for (at[3] = 0; at[3] < sizes_[3] && box[2][at[2]]; ++at[3]) {
                    if (box[3][at[3]] && cells[index(at)] == Cell::wanted) { used[at[slot]] = true; }
                }
            }
        }
    }
    return used;
}

/// The box as list items: "<RD'floor'>", or several single letters.
std::optional<std::vector<std::string>> EventWriter::box_text(const std::vector<Cell>& cells, const Box& box,
                                                              const std::string& label) const {
    std::array<std::vector<std::string>, slots> parts;
    std::array<std::string, slots> text;
    for (std::size_t slot = 0; slot < slots; ++slot) {
        if (std::find(box[slot].begin(), box[slot].end(), false) == box[slot].end()) {
            text[slot] = ".";
            continue;
        }
        Values outside(box[slot].size());
        std::transform(box[slot].begin(), box[slot].end(), outside.begin(), [](bool inside) { return !inside; });
        const Values used = values_in_use(cells, box, slot);
        const auto positive = choose(letters_[slot], used, outside);
        const auto negative = choose(letters_[slot], outside, used);
        if (!positive && !negative) { return std::nullopt; }
        if (positive && (!negative || joined(*positive).size() <= joined(*negative).size() + 1)) {
            parts[slot] = *positive;
            text[slot] = positive->size() == 1 ? positive->front() : "[" + joined(*positive) + "]";
        } else {
            text[slot] = "[^" + joined(*negative) + "]";
        }
    }
    if (!label.empty()) { text[2] = label; }
    const bool any_label = text[2] == "." && text[3] == ".";
    if (any_label && text[0] == "." && text[1] == ".") { return std::vector<std::string>{"."}; }
    // A list of letters that stands alone is a list of events.
    for (const std::size_t slot : {std::size_t{0}, std::size_t{1}}) {
        if (any_label && text[1 - slot] == "." && !parts[slot].empty()) { return parts[slot]; }
    }
    if (text[0] == "." && text[1] == "." && text[3] == "." && parts[2].size() == 1) { return parts[2]; }
    const std::string labels = any_label ? "" : text[3] == "." ? text[2] : text[2] + text[3];
    const std::string lobe = labels.empty() && text[1] == "." ? "" : text[1];
    return std::vector<std::string>{"<" + text[0] + lobe + labels + ">"};
}

bool EventWriter::holds(const Box& box, std::size_t cell) const {
    return box[3][cell % sizes_[3]] && box[2][cell / sizes_[3] % sizes_[2]] &&
           box[1][cell / (sizes_[2] * sizes_[3]) % sizes_[1]] && box[0][cell / (sizes_[1] * sizes_[2] * sizes_[3])];
}

/// The box around a cell that covers the most remaining cells; ties go to the shortest text.
std::optional<EventWriter::Box> EventWriter::best_box(const std::vector<Cell>& cells, const std::vector<Cell>& left,
                                                      std::size_t cell) const {
    const std::array<std::size_t, slots> at{cell / (sizes_[1] * sizes_[2] * sizes_[3]),
                                            cell / (sizes_[2] * sizes_[3]) % sizes_[1], cell / sizes_[3] % sizes_[2],
                                            cell % sizes_[3]};
    std::array<std::size_t, slots> order{0, 1, 2, 3};
    std::size_t most = 0, shortest = 0;
    std::optional<Box> best;
    do {
        Box box = grown(cells, at, order);
        std::size_t gain = 0;
        for (std::size_t i = 0; i < left.size(); ++i) { gain += left[i] == Cell::wanted && holds(box, i) ? 1U : 0U; }
        if (best && gain < most) { continue; }
        const auto text = box_text(cells, box);
        const std::size_t length = text ? joined(*text).size() : 0;
        if (text && (!best || gain > most || length < shortest)) {
            most = gain;
            shortest = length;
            best = std::move(box);
        }
    } while (std::next_permutation(order.begin(), order.end()));
    return best;
}

std::optional<std::vector<std::string>> EventWriter::cover(const std::vector<Cell>& cells,
                                                           const std::string& label) const {
    std::vector<Box> boxes;
    std::vector<Cell> left = cells;
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (left[k] != Cell::wanted) { continue; }
        std::optional<Box> box = best_box(cells, left, k);
        if (!box || boxes.size() >= most_boxes) { return std::nullopt; }
        for (std::size_t i = 0; i < left.size(); ++i) {
            left[i] = left[i] == Cell::wanted && holds(*box, i) ? Cell::free : left[i];
        }
        boxes.push_back(std::move(*box));
    }
    const auto by_last = texts(cells, boxes, label);
    std::reverse(boxes.begin(), boxes.end());
    const auto by_first = texts(cells, boxes, label);
    return !by_first || (by_last && joined(*by_last).size() <= joined(*by_first).size()) ? by_last : by_first;
}

/// The texts of the boxes of a cover. A cell that several boxes contain is written only by the last of them:
/// [<L.[^'key']>O] and not [<[LO].[^'key']>O].
std::optional<std::vector<std::string>> EventWriter::texts(const std::vector<Cell>& cells,
                                                           const std::vector<Box>& boxes,
                                                           const std::string& label) const {
    std::vector<std::string> items;
    std::vector<Cell> open = cells;
    for (std::size_t mine = boxes.size(); mine-- > 0;) {
        std::vector<Cell> later = open;
        bool needed = false;
        for (std::size_t i = 0; i < open.size(); ++i) {
            if (open[i] == Cell::wanted && holds(boxes[mine], i)) {
                needed = true;
                later[i] = Cell::free;
            }
        }
        if (!needed) { continue; }
        const auto text = box_text(open, boxes[mine], label);
        if (!text) { return std::nullopt; }
        items.insert(items.begin(), text->begin(), text->end());
        open = std::move(later);
    }
    return items;
}

std::optional<std::string> EventWriter::write(const ClassSet& wanted, const ClassSet& avoided) const {
    const auto as_list = [](const std::vector<std::string>& items, const char* opening) {
        return opening + joined(items) + "]";
    };
    const auto items = cover(table(wanted, avoided));
    std::optional<std::string> text;
    if (items && !items->empty()) { text = items->size() == 1 ? items->front() : as_list(*items, "["); }
    if (text && text->size() <= 4) {
        return text;  // no form with [^...] is shorter
    }
    const auto others = cover(table(avoided, wanted));
    if (others && !others->empty()) {
        std::string negative = as_list(*others, "[^");
        if (!text || negative.size() < text->size()) { text = std::move(negative); }
    }
    return text;
}

std::optional<std::string> EventWriter::write_labelled(const ClassSet& wanted, const ClassSet& avoided,
                                                       const std::string& label) const {
    const auto items = cover(table(wanted, avoided), label);
    return items && !items->empty() ? std::optional(joined(*items)) : std::nullopt;
}

}  // namespace raylex::lpe
