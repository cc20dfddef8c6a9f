#include "clients/gallery_server/refused.h"

#include "clients/gallery_server/gallery.h"

namespace sleight::gallery {

void refuse_unread(const Gallery& gallery, std::size_t archive) {
  constexpr unsigned k_still_reading = 503;
  const std::string why = gallery.why_unreadable(archive);
  if (!why.empty()) throw Refused(k_damaged, why, "");
  throw Refused(k_still_reading, "The archive has not been read yet.", "Retry in a moment.");
}

}  // namespace sleight::gallery
