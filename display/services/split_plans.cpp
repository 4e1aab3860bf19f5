#include "display/services/split_plans.h"

#include <algorithm>
#include <array>

namespace raylex::display {
namespace {

constexpr std::size_t first_room = 1024;
// With most_plans, all that is kept: 10 MiB of states, rows and plans at the most. A path tracer needs far less.
constexpr std::size_t most_words = 1 << 20, most_rows = 1 << 19;

std::uint64_t hash_of(const lpe::State* words, std::size_t count) {
    std::uint64_t hash = 0xCBF29CE484222325ull;  // FNV-1a, by words
    for (std::size_t i = 0; i < count; ++i) hash = (hash ^ words[i]) * 0x100000001B3ull;
    return hash;
}

}  // namespace

/// A plan under construction.
struct SplitPlans::Draft {
    struct Term {
        std::uint8_t from, factor;
    };
    std::vector<lpe::State> words;               // [branch afterwards][word]
    std::vector<std::vector<Term>> terms;        // [branch afterwards]
};

SplitPlans::SplitPlans(const lpe::Program& program, std::size_t capacity, std::size_t most_plans)
    : program_(program.view()),
      capacity_(capacity),
      most_plans_(most_plans),
      set_of_state_(program_.word_count == 1 ? program_.state_count : 0, unknown_set),
      words_(fixed_copy, lpe::Program::dead),
      plans_(first_room),
      plan_mask_(first_room - 1) {}

void SplitPlans::forget() {
    first_set_ += static_cast<std::uint32_t>(sets_.size());
    sets_.clear();
    set_index_.clear();
    words_.assign(fixed_copy, lpe::Program::dead);
    rows_.clear();
    plans_.assign(first_room, Plan{});
    plan_mask_ = first_room - 1;
    plan_count_ = 0;
}

std::uint32_t SplitPlans::find_set(const lpe::State* states, std::size_t count) {
    const std::size_t words = count * program_.word_count;
    const std::uint64_t hash = hash_of(states, words);
    const auto [begin, end] = set_index_.equal_range(hash);
    for (auto place = begin; place != end; ++place) {
        const Set& set = sets_[place->second - first_set_];
        if (set.count == count && std::equal(states, states + words, words_.begin() + set.first_word)) return place->second;
    }
    const auto set = static_cast<std::uint32_t>(first_set_ + sets_.size());
    sets_.push_back({static_cast<std::uint32_t>(words_.size() - fixed_copy), static_cast<std::uint32_t>(count)});
    words_.resize(words_.size() - fixed_copy);
    words_.insert(words_.end(), states, states + words);
    words_.resize(words_.size() + fixed_copy, lpe::Program::dead);
    set_index_.emplace(hash, set);
    return set;
}

SplitPlans::Plan& SplitPlans::insert(const Plan& plan) {
    std::size_t at = slot_of(plan.before, plan.events);
    while (plans_[at].before != unknown_set) at = (at + 1) & plan_mask_;
    return plans_[at] = plan;
}

const SplitPlans::Plan& SplitPlans::make(std::uint32_t set, std::uint64_t key, std::size_t lobes) {
    std::array<lpe::EventClass, most_lobes> events{};
    for (std::size_t j = 0; j < lobes; ++j) events[j] = static_cast<lpe::EventClass>(key >> 16 * (lobes - 1 - j));
    if (plan_count_ >= most_plans_ || words_.size() >= most_words || rows_.size() >= most_rows) {
        const Set kept = sets_[set - first_set_];
        const auto begin = words_.begin() + kept.first_word;
        const std::vector<lpe::State> states(begin, begin + static_cast<std::ptrdiff_t>(kept.count * program_.word_count));
        forget();
        set = set_of(states.data(), kept.count);
    }
    const std::size_t words = program_.word_count;
    constexpr std::uint8_t whole = 0, nothing = 1;
    const Set before = sets_[set - first_set_];
    static_assert(255 >= most_lobes * 48);  // rows of a plan: at most one for each branch and lobe
    Draft draft;
    Plan plan;
    std::vector<lpe::State> next(lobes * words);
    const auto add = [&](std::size_t branch, std::size_t lobe, std::uint8_t factor) {
        const lpe::State* state = &next[lobe * words];
        std::size_t at = 0;
        while (at < draft.terms.size() && !std::equal(state, state + words, &draft.words[at * words])) ++at;
        if (at == draft.terms.size()) {
            draft.words.insert(draft.words.end(), state, state + words);
            draft.terms.emplace_back();
        }
        draft.terms[at].push_back({static_cast<std::uint8_t>(branch), factor});
    };
    for (std::size_t branch = 0; branch < before.count; ++branch) {
        std::array<bool, most_lobes> alive{};
        bool agree = true;
        for (std::size_t j = 0; j < lobes; ++j) {
            alive[j] = program_.advance(&words_[before.first_word + branch * words], events[j], &next[j * words]);
            agree = agree && alive[j] == alive[0] &&
                    (!alive[j] || std::equal(&next[j * words], &next[j * words] + words, next.data()));
        }
        if (agree) {
            if (alive[0]) add(branch, 0, whole);  // the fractions sum to 1: nothing is split, nothing is rounded
            continue;
        }
        plan.splits = true;
        for (std::size_t j = 0; j < lobes; ++j)
            if (alive[j]) add(branch, j, static_cast<std::uint8_t>(first_lobe + j));
    }
    plan.fits = draft.terms.size() <= capacity_;
    if (plan.fits) {
        plan.count = static_cast<std::uint8_t>(draft.terms.size());
        plan.first_row = static_cast<std::uint32_t>(rows_.size());
        const auto add_row = [&](std::size_t to, std::size_t i) {
            const auto& terms = draft.terms[to];
            const auto term = [](const Draft::Term& each) { return Row::Term{each.from, each.factor}; };
            rows_.emplace_back(term(terms[i]), i + 1 < terms.size() ? term(terms[i + 1]) : Row::Term{terms[i].from, nothing}, to);
        };
        for (std::size_t to = 0; to < draft.terms.size(); ++to) add_row(to, 0);
        for (std::size_t to = 0; to < draft.terms.size(); ++to)
            for (std::size_t i = 2; i < draft.terms[to].size(); i += 2) add_row(to, i);
        plan.rows = static_cast<std::uint8_t>(rows_.size() - plan.first_row);
        plan.set = set_of(draft.words.data(), plan.count);
        plan.first_word = sets_[plan.set - first_set_].first_word;
    }
    plan.events = key;
    plan.before = set;
    plan.lobes = static_cast<std::uint8_t>(lobes);
    if (2 * ++plan_count_ > plans_.size()) {
        std::vector<Plan> old(2 * plans_.size());
        std::swap(old, plans_);
        plan_mask_ = plans_.size() - 1;
        for (const Plan& known : old)
            if (known.before != unknown_set) insert(known);
    }
    return insert(plan);
}

}  // namespace raylex::display
