// Keeps every contribution by its words for a path atlas, whatever channels there are.
#include <utility>

#include "display/services/samples/batch_path_strings.h"
#include "display/services/samples/lpe_services.h"

namespace raylex::display {

Status LpeSetup::keep_path_strings(PathAlphabet alphabet) {
    std::vector<lpe::EventClass> columns;
    for (std::size_t column = 0; column < alphabet.column_count(); ++column)
        columns.push_back(classify(alphabet.event(column)));
    constexpr std::size_t most_cells = std::size_t{1} << 26;  // 256 MiB: beyond it tables are no longer looked up fast
    const std::size_t per_column = program_.state_count() + program_.view().mask_stride;
    if (per_column * columns.size() > most_cells)
        return error_at({}, "the channels' automaton has " + std::to_string(program_.state_count()) +
                                " states and the scene " + std::to_string(columns.size()) +
                                " kinds of events, too many to follow both at once; expected fewer channels with "
                                "a path atlas, which can compute them afterwards");
    program_ = program_.with_columns(columns);
    find_main();
    alphabet_ = std::make_shared<const PathAlphabet>(std::move(alphabet));
    return success();
}

lpe::EventClass LpeSetup::column_of(const lpe::Event& event) const {
    return alphabet_->column(event);
}

void LpeServices::keep_move(Tracker& tracker, lpe::EventClass event) const {
    tracker.path_ = path_strings_->move(tracker.path_, event);
}

void LpeServices::keep_move(Tracker& tracker, std::span<const LobePart> parts) const {
    tracker.path_ = path_strings_->move(tracker.path_, parts);
}

void LpeServices::keep_light(const Rgb& value, Technique technique, const Tracker& tracker) const {
    path_strings_->add(tracker.row_, tracker.path_, value, technique);
}

}  // namespace raylex::display
