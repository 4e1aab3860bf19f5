#include "display/services/foresight/light_words.h"

#include <algorithm>
#include <array>
#include <utility>

#include "display/services/samples/branches.h"

namespace raylex::display {

LightWord LightWords::keep(std::span<const LobePart> parts, const LightWord* next) {
    LightWord word;
    word.state_ = static_cast<std::uint32_t>(events_.size());
    word.branches_ = next == nullptr ? 1 : next->branches_;
    if (!word.live() || parts.empty()) return {};
    events_.push_back({next == nullptr ? word.state_ : next->state_, static_cast<std::uint32_t>(parts_.size()),
                       static_cast<std::uint32_t>(parts.size())});
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    return word;
}

std::uint32_t LightWords::keep_path(std::span<const LobePart> parts, const LightWord* next) {
    if (!keeps_paths_ || parts.empty() || (next != nullptr && next->path_ == 0)) return 0;
    const auto place = static_cast<std::uint32_t>(events_.size());
    events_.push_back({next == nullptr ? place : next->path_ - 1, static_cast<std::uint32_t>(parts_.size()),
                       static_cast<std::uint32_t>(parts.size())});
    parts_.insert(parts_.end(), parts.begin(), parts.end());
    return place + 1;
}

LightWord LpeServices::begin(LightWords& words, lpe::EventClass terminal) const {
    LightWord word = begin_states(words, terminal);
    const LobePart only{terminal, Rgb(1)};
    word.path_ = words.keep_path({&only, 1}, nullptr);
    return word;
}

LightWord LpeServices::prepend(LightWords& words, const LightWord& word, lpe::EventClass event) const {
    LightWord longer = prepend_states(words, word, event);
    longer.length_ = static_cast<std::uint16_t>(word.length_ + 1);
    const LobePart all{event, Rgb(1)};
    longer.path_ = words.keep_path({&all, 1}, &word);
    return longer;
}

LightWord LpeServices::prepend(LightWords& words, const LightWord& word, std::span<const LobePart> parts,
                               std::uint64_t key) {
    LightWord longer = prepend_states(words, word, parts, key);
    longer.length_ = static_cast<std::uint16_t>(word.length_ + 1);
    longer.path_ = words.keep_path(parts, &word);
    return longer;
}

void LpeServices::join(Tracker& tracker, const LightWords& words, const LightWord& word) {
    for (std::uint32_t at = word.path_; path_words_ != nullptr && at != 0;) {
        const LightWords::Event& event = words.events_[at - 1];
        keep_move(tracker, {words.parts_.data() + event.first, event.count});
        at = event.next + 1 == at ? 0 : event.next + 1;
    }
    join_states(tracker, words, word);
}

LightWord LpeServices::begin_states(LightWords& words, lpe::EventClass terminal) const {
    if (words.language_ == nullptr) {
        const LobePart only{terminal, Rgb(1)};
        return words.keep({&only, 1}, nullptr);
    }
    LightWord word;
    word.state_ = static_cast<std::uint32_t>(words.states_.size());
    const std::span<const lpe::State> end = words.language_->starts();
    words.states_.insert(words.states_.end(), end.begin(), end.end());
    word.branches_ = 1;
    return prepend_states(words, word, terminal);
}

LightWord LpeServices::prepend_states(LightWords& words, const LightWord& word, lpe::EventClass event) const {
    const LobePart all{event, Rgb(1)};
    if (words.language_ == nullptr) return words.keep({&all, 1}, &word);
    if (!word.whole_) return prepend_split(words, word, {&all, 1}, 0).word;
    LightWord longer = word;
    if (word.branches_ == 0) return longer;
    const std::size_t at = words.states_.size();
    longer.state_ = static_cast<std::uint32_t>(at);
    words.states_.resize(at + words.language_->word_count());
    // A language without words, where an atlas alone is asked for, has no states to point at.
    longer.branches_ = words.language_->prepend(words.states(word), event, words.states_.data() + at);
    return longer;
}

LightWord LpeServices::prepend_states(LightWords& words, const LightWord& word, std::span<const LobePart> parts,
                                      std::uint64_t key) {
    if (words.language_ == nullptr) return words.keep(parts, &word);
    if (word.branches_ == 0 || parts.size() == 1)
        return parts.empty() ? word : prepend_states(words, word, parts[0].event);
    if (parts.empty()) return {};
    const SplitWord split = prepend_split(words, word, parts, key);
    if (split.overflow) ++overflow_count_;
    return split.word;
}

LpeServices::SplitWord LpeServices::prepend_split(LightWords& words, const LightWord& word,
                                                  std::span<const LobePart> parts, std::uint64_t key) const {
    const lpe::ReversedProgram& language = *words.language_;
    ChoiceNumbers numbers([&] { return mix64(mix64(seed_ + 0x9e3779b97f4a7c15ull) ^ key); });
    Fractions fractions(parts);
    if (attribution_ == Attribution::picked) fractions.pick(numbers.next());
    BranchList branches(language.word_count());
    branches.split({words.states(word), words.shares(word), word.branches_, language.word_count()}, parts, fractions,
                   LightWords::capacity, numbers, [&](const lpe::State* from, lpe::EventClass event, lpe::State* to) {
                       return language.prepend(from, event, to);
                   });
    SplitWord result;
    result.overflow = branches.overflow;
    LightWord& longer = result.word;
    longer.state_ = static_cast<std::uint32_t>(words.states_.size());
    longer.share_ = static_cast<std::uint32_t>(words.shares_.size());
    longer.branches_ = static_cast<std::uint8_t>(branches.count);
    longer.whole_ = branches.whole;
    const auto states = branches.state.begin();
    words.states_.insert(words.states_.end(), states,
                         states + static_cast<std::ptrdiff_t>(branches.count * language.word_count()));
    const auto shares = branches.share.begin();
    if (!branches.whole)
        words.shares_.insert(words.shares_.end(), shares, shares + static_cast<std::ptrdiff_t>(branches.count));
    return result;
}

void LpeServices::join_states(Tracker& tracker, const LightWords& words, const LightWord& word) {
    if (tracker.count_ == 0) return;
    if (words.language_ == nullptr) {
        if (!word.live()) tracker.count_ = 0;
        for (std::uint32_t at = word.state_; tracker.count_ != 0;) {
            const LightWords::Event& event = words.events_[at];
            move_states(tracker, {words.parts_.data() + event.first, event.count});
            if (event.next == std::exchange(at, event.next)) return;
        }
        return;
    }
    const lpe::ReversedProgram& language = *words.language_;
    if (tracker.whole_ && word.whole_) {
        lpe::State* const state = tracker.state_.data();
        tracker.count_ = word.branches_ != 0 && language.join(state, words.states(word), state);
        return;
    }
    // One move for each event, so that the connections of one camera vertex choose by numbers of their own.
    tracker.moves_ = static_cast<std::uint16_t>(tracker.moves_ + word.length_);
    ChoiceNumbers numbers([&] { return random_key(tracker, {}); });
    const std::size_t target = branch_limit(tracker);
    const Branches of_camera = branches_of(tracker);
    const Branches of_light{words.states(word), words.shares(word), word.branches_, language.word_count()};
    BranchList joined(of_camera.words);
    const auto shrink = [&] {
        joined.collapse(target, numbers.next());
        joined.overflow = true;
    };
    joined.whole = false;
    for (std::size_t i = 0; i < of_camera.count; ++i)
        for (std::size_t k = 0; k < of_light.count; ++k) {
            if (!joined.has_room_for(1)) shrink();
            lpe::State* const whole = joined.candidates();
            if (!language.join(of_camera.state_of(i), of_light.state_of(k), whole)) continue;
            const RgbD share = of_camera.share_of(i) * of_light.share_of(k);
            if (share.r != 0 || share.g != 0 || share.b != 0) joined.add(whole, share);
        }
    if (joined.count > target) shrink();
    take(tracker, joined);
}

}  // namespace raylex::display
