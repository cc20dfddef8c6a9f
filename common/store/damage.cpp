#include "common/store/damage.h"

namespace sleight::store {

bool tells_of_damage(std::string_view words) {
  return words.find(k_damaged_words) != std::string_view::npos ||
         words.find(k_no_store_words) != std::string_view::npos;
}

}  // namespace sleight::store
