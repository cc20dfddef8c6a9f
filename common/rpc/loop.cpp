#include "common/rpc/loop.h"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <string>
#include <utility>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/rpc/event_descriptor.h"
#include "common/rpc/from_now.h"
#include "common/rpc/loop_impl.h"

namespace sleight::rpc {
namespace {

constexpr std::array<int, 3> k_stop_signals = {SIGTERM, SIGINT, SIGHUP};

/// Descriptor that the signal handler writes to; -1: none.
std::atomic<int> signal_target = -1;

/// Returns how much a signal adds to the eventfd's count. SIGTERM, SIGINT and SIGHUP each use 16
/// bits of the count.
constexpr std::uint64_t signal_unit(std::size_t index) {
  return std::uint64_t{1} << (16 * index);
}

void heard_signal(int signal) {
  const int saved = errno;
  for (std::size_t i = 0; i < k_stop_signals.size(); ++i) {
    if (k_stop_signals[i] != signal) continue;
    const std::uint64_t unit = signal_unit(i);
    [[maybe_unused]] const auto written = ::write(signal_target.load(), &unit, sizeof unit);
  }
  errno = saved;
}

bool is_readable(int descriptor) {
  pollfd looked = {.fd = descriptor, .events = POLLIN, .revents = 0};
  return ::poll(&looked, 1, 0) > 0;
}

}  // namespace

// ---------------------------------------------------------------------------------------- handles

/// A handle's promise waits for its event and calls the callback. If a callback destroys its own
/// handle, the loop takes over the promise, because a promise can't destroy itself.
struct Loop::Handle::State {
  State(Impl& loop_impl, Callback to_call) : loop(loop_impl), callback(std::move(to_call)) {}

  void call() {
    is_calling = true;
    loop.call(callback);
    is_calling = false;
  }

  Impl& loop;
  Callback callback;
  bool is_calling = false;
  bool is_over = false;
  int descriptor = -1;
  double period_s = 0;
  kj::Own<kj::UnixEventPort::FdObserver> observer;
  kj::Maybe<kj::Promise<void>> promise;
};

namespace {

using State = Loop::Handle::State;

kj::Promise<void> tick(const std::shared_ptr<State>& state) {
  return state->loop.timer().atTime(from_now(state->period_s)).then([state]() -> kj::Promise<void> {
    if (state->is_over) return kj::READY_NOW;
    state->call();
    if (state->is_over) return kj::READY_NOW;
    return tick(state);
  });
}

kj::Promise<void> look(const std::shared_ptr<State>& state) {
  // Check again whether the descriptor is still readable, because KJ reports only changes.
  auto ready =
      is_readable(state->descriptor) ? kj::evalLast([] {}) : state->observer->whenBecomesReadable();
  return ready.then([state]() -> kj::Promise<void> {
    if (state->is_over) return kj::READY_NOW;
    if (is_readable(state->descriptor)) state->call();
    if (state->is_over) return kj::READY_NOW;
    return look(state);
  });
}

}  // namespace

Loop::Handle::Handle() = default;
Loop::Handle::Handle(std::shared_ptr<State> state) : state_(std::move(state)) {}
Loop::Handle::Handle(Handle&&) noexcept = default;

Loop::Handle& Loop::Handle::operator=(Handle&& other) noexcept {
  if (this != &other) {
    end();
    state_ = std::move(other.state_);
  }
  return *this;
}

Loop::Handle::~Handle() {
  end();
}

void Loop::Handle::end() {
  if (!state_) return;
  const std::shared_ptr<State> state = std::exchange(state_, nullptr);
  state->is_over = true;
  KJ_IF_MAYBE (promise, state->promise) {
    kj::Promise<void> ended = kj::mv(*promise);
    state->promise = nullptr;
    if (state->is_calling) {
      // The promise's continuation is running now. It sees `is_over` and ends.
      state->loop.tasks.add(kj::mv(ended));
    }
  }
  // Destroy the promise at once, because the caller may close the descriptor next.
  state->observer = nullptr;
}

// ---------------------------------------------------------------------------------------- the loop

Loop::Impl::Impl()
    : io(kj::setupAsyncIo()),
      wake_descriptor(make_event_descriptor()),
      wakes(io.unixEventPort, wake_descriptor.get(), kj::UnixEventPort::FdObserver::OBSERVE_READ),
      tasks(*this) {
  tasks.add(look_at_wake());
}

Loop::Impl::~Impl() {
  if (signal_descriptor.get() < 0) return;
  for (const int signal : k_stop_signals)
    ::signal(signal, SIG_DFL);
  signal_target = -1;
}

void Loop::Impl::fail(std::exception_ptr failure) {
  if (!error) error = std::move(failure);
  if (running) running->fulfill();
}

void Loop::Impl::call(const Callback& callback) {
  try {
    callback();
  } catch (...) {
    fail(std::current_exception());
  }
}

void Loop::Impl::taskFailed(kj::Exception&& exception) {
  fail(std::make_exception_ptr(
      base::Error(base::ExitCode::bug,
                  std::string("the event loop failed: ") + exception.getDescription().cStr())));
}

void Loop::Impl::wake_up() const {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_descriptor.get(), &one, sizeof one);
}

void Loop::Impl::run_posted() {
  std::vector<Callback> now;
  {
    const std::lock_guard lock(posted_mutex);
    now.swap(posted);
  }
  for (const Callback& callback : now)
    call(callback);
}

kj::Promise<void> Loop::Impl::look_at_wake() {
  return wakes.whenBecomesReadable().then([this]() -> kj::Promise<void> {
    drain_events(wake_descriptor.get());
    run_posted();
    if (is_stopped && running) running->fulfill();
    return look_at_wake();
  });
}

kj::Promise<void> Loop::Impl::look_at_signals() {
  return signals->whenBecomesReadable().then([this]() -> kj::Promise<void> {
    const std::uint64_t heard = drain_events(signal_descriptor.get());
    for (std::size_t i = 0; i < k_stop_signals.size(); ++i) {
      if ((heard / signal_unit(i)) % signal_unit(1) > 0)
        call([this, i] { on_signal(k_stop_signals[i]); });
    }
    return look_at_signals();
  });
}

Loop::Loop() : impl_(std::make_unique<Impl>()) {}
Loop::~Loop() = default;

void Loop::run() {
  CHECK(impl_->running.get() == nullptr);
  auto end = kj::newPromiseAndFulfiller<void>();
  impl_->running = kj::mv(end.fulfiller);
  if (impl_->is_stopped || impl_->error) impl_->running->fulfill();
  end.promise.wait(impl_->io.waitScope);
  impl_->running = nullptr;
  impl_->is_stopped = false;
  if (impl_->error) std::rethrow_exception(std::exchange(impl_->error, nullptr));
}

void Loop::stop() {
  impl_->is_stopped = true;
  impl_->wake_up();
}

Loop::Handle Loop::call_later(double seconds, Callback callback) {
  auto state = std::make_shared<State>(*impl_, std::move(callback));
  state->promise = impl_->timer()
                       .atTime(from_now(seconds))
                       .then([weak = std::weak_ptr(state)] {
                         const auto held = weak.lock();
                         if (held && !held->is_over) held->call();
                       })
                       .eagerlyEvaluate([](kj::Exception&&) {});
  return Handle(std::move(state));
}

Loop::Handle Loop::call_every(double seconds, Callback callback) {
  CHECK_GT(seconds, 0.0);
  auto state = std::make_shared<State>(*impl_, std::move(callback));
  state->period_s = seconds;
  state->promise = tick(state).eagerlyEvaluate([](kj::Exception&&) {});
  return Handle(std::move(state));
}

Loop::Handle Loop::call_when_readable(int descriptor, Callback callback) {
  auto state = std::make_shared<State>(*impl_, std::move(callback));
  state->descriptor = descriptor;
  state->observer = kj::heap<kj::UnixEventPort::FdObserver>(
      impl_->io.unixEventPort, descriptor, kj::UnixEventPort::FdObserver::OBSERVE_READ);
  state->promise = look(state).eagerlyEvaluate([](kj::Exception&&) {});
  return Handle(std::move(state));
}

void Loop::post(Callback callback) {
  {
    const std::lock_guard lock(impl_->posted_mutex);
    impl_->posted.push_back(std::move(callback));
  }
  impl_->wake_up();
}

void Loop::on_stop_signals(std::function<void(int signal)> callback) {
  CHECK_EQ(signal_target.load(), -1);
  impl_->signal_descriptor = make_event_descriptor();
  impl_->on_signal = std::move(callback);
  impl_->signals = kj::heap<kj::UnixEventPort::FdObserver>(
      impl_->io.unixEventPort, impl_->signal_descriptor.get(),
      kj::UnixEventPort::FdObserver::OBSERVE_READ);
  signal_target = impl_->signal_descriptor.get();
  struct sigaction action {};
  action.sa_handler = heard_signal;
  for (const int signal : k_stop_signals)
    ::sigaction(signal, &action, nullptr);
  impl_->tasks.add(impl_->look_at_signals());
}

}  // namespace sleight::rpc
