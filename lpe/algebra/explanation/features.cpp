#include "lpe/algebra/explanation/features.h"

#include <utility>

namespace raylex::lpe {

namespace {

bool has_feature(const Event& event, Feature feature) {
    switch (feature) {
        case Feature::volume:
            return event.type == EventType::volume;
        case Feature::background:
            return event.type == EventType::background;
        case Feature::emission:
            return event.type == EventType::emission;
        case Feature::straight:
            return event.scatter == Scatter::straight;
        case Feature::light:
            return event.type == EventType::light;
        case Feature::diffuse:
            return event.scatter == Scatter::diffuse;
        case Feature::glossy:
            return event.scatter == Scatter::glossy;
        case Feature::singular:
            return event.scatter == Scatter::singular;
    }
    return false;
}

NodePtr anything() {
    EventSet all{{{{}, {}, Missing::is_empty, Extra::ignored}}, {}};
    all.any_of.front().cores.set();
    NodePtr node = make_node(NodeKind::repeat);
    node->max = Node::unbounded;
    node->children.push_back(make_event(std::move(all)));
    return node;
}

}  // namespace

Expression path_strings_with(Feature feature) {
    EventSet set{{{{}, {}, Missing::is_empty, Extra::ignored}}, {}};
    for (std::size_t core = 0; core < core_count; ++core) {
        set.any_of.front().cores[core] = has_feature(core_event(core), feature);
    }
    Expression expression;
    expression.dialect = Dialect::osl;
    expression.root = make_node(NodeKind::sequence);
    expression.root->children.push_back(anything());
    expression.root->children.push_back(make_event(std::move(set)));
    expression.root->children.push_back(anything());
    return expression;
}

}  // namespace raylex::lpe
