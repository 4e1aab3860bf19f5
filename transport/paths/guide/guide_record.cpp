// A GuideTree as bytes, for checkpoints.
#include <algorithm>
#include <numeric>

#include "display/buffer/record_bytes.h"
#include "transport/paths/guide/guide_tree.h"

namespace raylex::transport {
namespace {

template <class Item>
void write_items(display::RecordWriter& writer, const std::vector<Item>& items) {
    writer.text({reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item)});
}

template <class Item>
std::vector<Item> read_items(display::RecordReader& reader) {
    const std::string bytes = reader.text();
    std::vector<Item> items(bytes.size() / sizeof(Item));
    if (!items.empty()) std::memcpy(items.data(), bytes.data(), items.size() * sizeof(Item));
    return items;
}

}  // namespace

void GuideTree::append_record(std::string& bytes) const {
    display::RecordWriter writer(bytes);
    for (const Vec3& each : {lower_, scale_, size_})
        for (int i = 0; i < 3; ++i) writer.number(each[i]);
    write_items(writer, space_);
    write_items(writer, regions_);
    write_items(writer, nodes_);
}

std::optional<GuideTree> GuideTree::from_record(std::string_view bytes) {
    GuideTree tree{Bounds()};
    display::RecordReader reader(bytes);
    for (Vec3* each : {&tree.lower_, &tree.scale_, &tree.size_})
        for (int i = 0; i < 3; ++i) (*each)[i] = reader.number<Real>();
    tree.space_ = read_items<Space>(reader);
    tree.regions_ = read_items<Region>(reader);
    tree.nodes_ = read_items<Node>(reader);
    if (!reader.at_end() || !tree.is_sound()) return std::nullopt;
    return tree;
}

/// Whether every lookup ends within the tree: each index is that of a later item.
bool GuideTree::is_sound() const {
    if (space_.size() < orientations) return false;
    for (std::size_t i = 0; i < space_.size(); ++i) {
        const Space& each = space_[i];
        const bool leaf = each.first == 0;
        if (leaf ? each.region >= regions_.size() : each.first <= i || each.first + 1 >= space_.size()) return false;
    }
    for (std::size_t i = 1; i < nodes_.size(); ++i) {
        const Node& each = nodes_[i];
        if (std::accumulate(each.mass.begin(), each.mass.end(), 0u) != Node::whole) return false;
        for (std::uint32_t q = 0; q < 4; ++q)
            if (const std::uint32_t child = each.child(q); child != 0 && (child <= i || child >= nodes_.size()))
                return false;
    }
    return std::all_of(regions_.begin(), regions_.end(), [&](const Region& each) {
        return each.root > 0 && each.root < nodes_.size() && each.share >= 0 && each.share < 1 && each.by_square >= 0 &&
               each.by_noise >= 0 && each.by_light >= 0;
    });
}

}  // namespace raylex::transport
