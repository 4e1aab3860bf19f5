#include "lpe/language/class_table.h"

#include <algorithm>
#include <span>

#include "lpe/language/glob.h"
#include "lpe/language/pattern.h"

namespace raylex::lpe {

std::uint32_t ClassTable::classify(const Event& event) const {
    std::size_t count = event.labels.size();
    while (count > 0 && event.labels[count - 1].empty()) { --count; }
    const Node* node = &nodes[node_of_core[core_index(event)]];
    std::vector<std::uint8_t> matched;
    for (std::size_t slot = 0; slot < count && node->leaf == 0; ++slot) {
        const std::string_view label = event.labels[slot];
        const std::span<const Name> named(names.data() + node->first_name, node->names);
        const auto place =
            std::lower_bound(named.begin(), named.end(), label,
                             [this](const Name& name, std::string_view wanted) { return text(name.text) < wanted; });
        if (place != named.end() && text(place->text) == label) {
            node = &nodes[place->node];
            continue;
        }
        matched.clear();
        for (std::uint32_t k = 0; k < node->globs; ++k) {
            matched.push_back(glob_matches(text(globs[node->first_glob + k]), label) ? 1 : 0);
        }
        const Node* next = nullptr;
        for (std::uint32_t k = 0; k < node->kinds && next == nullptr; ++k) {
            const Kind& kind = kinds[node->first_kind + k];
            if (std::equal(matched.begin(), matched.end(), matches.begin() + kind.first_match)) {
                next = &nodes[kind.node];
            }
        }
        if (next == nullptr) { return 0; }
        node = next;
    }
    return node->end_class;
}

}  // namespace raylex::lpe
