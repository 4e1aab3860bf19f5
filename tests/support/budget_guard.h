// Smaller budgets during a test, so that input beyond them is small too.
#pragma once

#include <string>
#include <vector>

#include "lpe/input/budgets.h"

namespace raylex::test {

class BudgetGuard {
  public:
    /// Sets the budgets "NAME=VALUE,...".
    explicit BudgetGuard(const std::string& assignments) {
        for (std::size_t i = 0; i < budget_table().size(); ++i) saved_.push_back(budget(static_cast<Budget>(i)));
        good_ = set_budgets(assignments).ok();
    }
    ~BudgetGuard() {
        for (std::size_t i = 0; i < saved_.size(); ++i)
            static_cast<void>(set_budget(std::string(budget_table()[i].name) + "=" + std::to_string(saved_[i])));
    }
    BudgetGuard(const BudgetGuard&) = delete;
    BudgetGuard& operator=(const BudgetGuard&) = delete;
    [[nodiscard]] bool good() const { return good_; }

  private:
    std::vector<std::uint64_t> saved_;
    bool good_ = false;
};

}  // namespace raylex::test
