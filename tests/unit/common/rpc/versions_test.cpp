// Programs of different ages understand each other.
//
// Method: the schema of the first version, which is kept beside this file, today's, and one of a
// future in which every kind of thing was added, are read from their texts; clients and servers by
// the first and the last one speak with today's over a socket.
#include <capnp/dynamic.h>
#include <capnp/rpc-twoparty.h>
#include <capnp/schema-loader.h>
#include <capnp/schema-parser.h>
#include <fmt/format.h>
#include <kj/async-io.h>
#include <kj/filesystem.h>
#include <unistd.h>

#include <condition_variable>
#include <fstream>
#include <iterator>
#include <mutex>

#include "common/rpc/client.h"
#include "common/rpc/unix_socket.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

using testing::FakeService;
using testing::ServerThread;

const char* const k_today = SLEIGHT_SOURCE "/common/schema/service.capnp";
const char* const k_first = SLEIGHT_SOURCE "/tests/unit/common/rpc/service_v1.capnp";

std::string text_of(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return place == std::string::npos ? text : text.replace(place, from.size(), to);
}

/// Today's schema with additions of each kind: a field in a request and in an answer, a value of
/// each enumeration, a member of a union, a call.
std::string future_text() {
  std::string text = text_of(k_today);
  text = replaced(text, "  strict @6 :Bool;", "  nextWish @8 :Text;\n  strict @6 :Bool;");
  text =
      replaced(text, "  repeatCommand @37 :Text;",
               "  nextView @39 :Text;\n  nextNumber @40 :UInt64 = 7;\n  repeatCommand @37 :Text;");
  text = replaced(text, "  cancelled @8;", "  cancelled @8;\n  nextState @9;");
  text = replaced(text, "    bug @9; ", "    nextKind @10;\n    bug @9; ");
  text = replaced(text, "    failureFiles @4;", "    nextFiles @5;\n    failureFiles @4;");
  text = replaced(text, "    group @1 :UInt64;\n  }",
                  "    group @1 :UInt64;\n    nextTarget @2 :Text;\n  }");
  return replaced(
      text, "  info @13 ()",
      "  nextCall @19 (wish :Text) -> (refusal :Refusal, answer :Text);\n  info @13 ()");
}

/// A schema read from its text.
class Age {
 public:
  explicit Age(const std::string& text) : files_(kj::newDiskFilesystem()) {
    auto folder = kj::newInMemoryDirectory(kj::nullClock());
    folder->openFile(kj::Path("service.capnp"), kj::WriteMode::CREATE)
        ->writeAll(kj::StringPtr(text.c_str()));
    folder
        ->openFile(kj::Path({"capnp", "c++.capnp"}),
                   kj::WriteMode::CREATE | kj::WriteMode::CREATE_PARENT)
        ->writeAll(kj::StringPtr(text_of("/usr/include/capnp/c++.capnp").c_str()));
    folder_ = kj::mv(folder);
    const kj::ReadableDirectory* imports[] = {folder_.get()};
    schema_ =
        parser_.parseFromDirectory(*folder_, kj::Path("service.capnp"), kj::arrayPtr(imports, 1));
  }

  capnp::InterfaceSchema interface(const char* name) {
    return schema_.getNested(name).asInterface();
  }
  capnp::SchemaParser& parser() { return parser_; }
  capnp::ParsedSchema schema() const { return schema_; }

 private:
  kj::Own<kj::Filesystem> files_;
  kj::Own<const kj::ReadableDirectory> folder_;
  capnp::SchemaParser parser_;
  capnp::ParsedSchema schema_;
};

/// All nodes under one.
void load_all(capnp::SchemaLoader& loader, capnp::ParsedSchema schema) {
  loader.load(schema.getProto());
  for (const auto nested : schema.getAllNested())
    load_all(loader, nested);
  if (!schema.getProto().isInterface()) return;
  for (const auto method : schema.asInterface().getMethods()) {
    loader.load(method.getParamType().getProto());
    loader.load(method.getResultType().getProto());
  }
}

bool goes_with(const std::string& older, const std::string& newer) {
  Age before(older);
  Age after(newer);
  capnp::SchemaLoader loader;
  try {
    load_all(loader, before.schema());
    load_all(loader, after.schema());
  } catch (const kj::Exception&) {
    return false;
  }
  return true;
}

/// A client by any age's schema.
class OtherClient {
 public:
  OtherClient(Age& age, const std::string& path)
      : stream_(io_.lowLevelProvider->wrapSocketFd(connect_to(path).value(),
                                                   kj::LowLevelAsyncIoProvider::TAKE_OWNERSHIP)),
        network_(*stream_, capnp::rpc::twoparty::Side::CLIENT),
        system_(capnp::makeRpcClient(network_)) {
    capnp::MallocMessageBuilder builder;
    auto vat = builder.initRoot<capnp::rpc::twoparty::VatId>();
    vat.setSide(capnp::rpc::twoparty::Side::SERVER);
    auto entrance =
        system_.bootstrap(vat).castAs<capnp::DynamicCapability>(age.interface("Entrance"));
    auto opened = entrance.newRequest("open").send().wait(io_.waitScope);
    service_ = opened.get("service").as<capnp::DynamicCapability>();
  }

  capnp::Request<capnp::DynamicStruct, capnp::DynamicStruct> request(const char* call) {
    return service_.newRequest(call);
  }
  capnp::Response<capnp::DynamicStruct> send(
      capnp::Request<capnp::DynamicStruct, capnp::DynamicStruct>& request) {
    return request.send().wait(io_.waitScope);
  }

 private:
  kj::AsyncIoContext io_ = kj::setupAsyncIo();
  kj::Own<kj::AsyncIoStream> stream_;
  capnp::TwoPartyVatNetwork network_;
  capnp::RpcSystem<capnp::rpc::twoparty::VatId> system_;
  capnp::DynamicCapability::Client service_;
};

/// A service by any age's schema.
class OtherService final : public capnp::DynamicCapability::Server {
 public:
  using Answer = std::function<void(kj::StringPtr call, capnp::DynamicStruct::Reader params,
                                    capnp::DynamicStruct::Builder results)>;
  OtherService(capnp::InterfaceSchema by, Answer answer)
      : capnp::DynamicCapability::Server(by), answer_(std::move(answer)) {}

  kj::Promise<void> call(
      capnp::InterfaceSchema::Method method,
      capnp::CallContext<capnp::DynamicStruct, capnp::DynamicStruct> context) override {
    answer_(method.getProto().getName(), context.getParams(), context.getResults());
    return kj::READY_NOW;
  }

 private:
  Answer answer_;
};

/// Such a service behind a socket, in a thread.
class OtherServer {
 public:
  OtherServer(const std::string& text, const std::string& path, OtherService::Answer answer)
      : socket_(path), thread_([this, text, answer = std::move(answer)] { run(text, answer); }) {}
  ~OtherServer() {
    {
      const std::lock_guard lock(mutex_);
      (*end_)->fulfill();
    }
    thread_.join();
  }

 private:
  void run(const std::string& text, const OtherService::Answer& answer) {
    auto io = kj::setupAsyncIo();
    Age age(text);
    capnp::DynamicCapability::Client service =
        kj::heap<OtherService>(age.interface("Service"), answer);
    capnp::DynamicCapability::Client entrance = kj::heap<OtherService>(
        age.interface("Entrance"),
        [&](kj::StringPtr, capnp::DynamicStruct::Reader, capnp::DynamicStruct::Builder results) {
          results.set("service", service);
        });
    auto receiver = io.lowLevelProvider->wrapListenSocketFd(socket_.descriptor());
    capnp::TwoPartyServer server(entrance);
    auto end = kj::newPromiseAndCrossThreadFulfiller<void>();
    {
      const std::lock_guard lock(mutex_);
      end_ =
          std::make_unique<kj::Own<kj::CrossThreadPromiseFulfiller<void>>>(kj::mv(end.fulfiller));
    }
    started_.notify_one();
    server.listen(*receiver).exclusiveJoin(kj::mv(end.promise)).wait(io.waitScope);
  }

  ListeningSocket socket_;
  std::mutex mutex_;
  std::condition_variable started_;
  std::unique_ptr<kj::Own<kj::CrossThreadPromiseFulfiller<void>>> end_;
  std::thread thread_;

 public:
  void wait_for_start() {
    std::unique_lock lock(mutex_);
    started_.wait(lock, [&] { return end_ != nullptr; });
  }
};

class VersionsTest : public testing::SocketFolder {
 protected:
  VersionsTest() {
    service.jobs[1] = {.view = {.id = {1},
                                .name = "one",
                                .state = JobState::running,
                                .left_s = 3,
                                .history = {testing::change_of(1)}},
                       .events = 2,
                       .is_over = true};
    service.add_file("ball.h5", "content");
  }
  FakeService service;
};

TEST_F(VersionsTest, FieldsAreOnlyEverAdded) {
  // Goal: today's schema goes with the first one, and a change that breaks this is found. Method:
  // Cap'n Proto's own judgement; planted changes of a field's type, of numbers, of an enumeration,
  // of a call.
  const std::string today = text_of(k_today);
  EXPECT_TRUE(goes_with(text_of(k_first), today));
  EXPECT_TRUE(goes_with(today, future_text()));
  EXPECT_FALSE(goes_with(today, replaced(today, "priority @5 :Int32;", "priority @5 :Text;")));
  EXPECT_FALSE(goes_with(today, replaced(today, "  ranks @3 :UInt32;  # of mpirun",
                                         "  ranks @3 :UInt64;  # of mpirun")));
  EXPECT_FALSE(
      goes_with(today, replaced(today, "status @2 (job :UInt64)", "status @2 (job :Text)")));
}

void expect_a_whole_conversation(OtherClient& client, FakeService& service) {
  auto submit = client.request("submit");
  auto submission = submit.init("submission").as<capnp::DynamicStruct>();
  submission.set("key", "old key");
  auto job = submission.init("jobs", 1).as<capnp::DynamicList>()[0].as<capnp::DynamicStruct>();
  job.set("name", "a");
  job.set("request", "text");
  const auto submitted = client.send(submit);
  EXPECT_FALSE(submitted.has("refusal"));
  EXPECT_EQ(service.submissions.back().jobs.front().request, "text");

  auto status = client.request("status");
  status.set("job", 1);
  const auto answered = client.send(status);
  const auto view = answered.get("job").as<capnp::DynamicStruct>();
  EXPECT_EQ(view.get("name").as<capnp::Text>(), "one");
  EXPECT_EQ(view.get("left").as<double>(), 3);
  auto none = client.request("status");
  none.set("job", 99);
  EXPECT_TRUE(client.send(none).has("refusal"));

  auto watch = client.request("watch");
  watch.init("points", 1).as<capnp::DynamicList>()[0].as<capnp::DynamicStruct>().set("job", 1);
  const auto watched = client.send(watch);
  const auto batch = watched.get("batches").as<capnp::DynamicList>()[0].as<capnp::DynamicStruct>();
  EXPECT_EQ(batch.get("events").as<capnp::DynamicList>().size(), 3U);
  EXPECT_TRUE(batch.get("settled").as<bool>());

  auto fetch = client.request("fetch");
  auto ask = fetch.init("ask").as<capnp::DynamicStruct>();
  ask.set("job", 1);
  ask.set("kind", "archive");
  const auto fetched = client.send(fetch);
  const auto file = fetched.get("files").as<capnp::DynamicList>()[0].as<capnp::DynamicStruct>();
  auto read = file.get("file").as<capnp::DynamicCapability>().newRequest("read");
  read.set("offset", 3);
  read.set("bytes", 4);
  EXPECT_EQ(client.send(read).get("piece").as<capnp::Data>(), kj::StringPtr("tent").asBytes());
}

TEST_F(VersionsTest, TheFirstClientSpeaksWithTodaysServer) {
  // Goal: a client of the first version has all that it knows. Method: a conversation by its
  // schema.
  ServerThread server(socket(), service);
  Age first(text_of(k_first));
  OtherClient client(first, socket());
  expect_a_whole_conversation(client, service);
}

TEST_F(VersionsTest, AFutureClientSpeaksWithTodaysServer) {
  // Goal: additions of a newer client are left aside, or refused where they change the meaning;
  // never misread. Method: a conversation by the future's schema; then its new field, values and
  // call.
  ServerThread server(socket(), service);
  Age future(future_text());
  OtherClient client(future, socket());
  expect_a_whole_conversation(client, service);

  auto submit = client.request("submit");
  auto submission = submit.init("submission").as<capnp::DynamicStruct>();
  submission.set("key", "new key");
  auto job = submission.init("jobs", 1).as<capnp::DynamicList>()[0].as<capnp::DynamicStruct>();
  job.set("request", "text");
  job.set("nextWish", "more");
  EXPECT_FALSE(client.send(submit).has("refusal"));

  const auto kind_of = [](const capnp::Response<capnp::DynamicStruct>& response) {
    return std::string(response.get("refusal")
                           .as<capnp::DynamicStruct>()
                           .get("kind")
                           .as<capnp::DynamicEnum>()
                           .getEnumerant()
                           .orDefault([]() -> capnp::EnumSchema::Enumerant {
                             throw std::runtime_error("no such kind");
                           })
                           .getProto()
                           .getName()
                           .cStr());
  };
  auto list = client.request("list");
  list.init("ask")
      .as<capnp::DynamicStruct>()
      .init("states", 1)
      .as<capnp::DynamicList>()
      .set(0, "nextState");
  EXPECT_EQ(kind_of(client.send(list)), "badRequest");
  auto fetch = client.request("fetch");
  auto ask = fetch.init("ask").as<capnp::DynamicStruct>();
  ask.set("job", 1);
  ask.set("kind", "nextFiles");
  EXPECT_EQ(kind_of(client.send(fetch)), "badRequest");
  auto cancel = client.request("cancel");
  cancel.init("target").as<capnp::DynamicStruct>().set("nextTarget", "all");
  EXPECT_EQ(kind_of(client.send(cancel)), "notFound");
  EXPECT_TRUE(service.calls.empty());
  auto next = client.request("nextCall");
  EXPECT_THROW(client.send(next), kj::Exception);
}

/// What a service of any age answers.
void answer_as_of_old(kj::StringPtr call, capnp::DynamicStruct::Reader params,
                      capnp::DynamicStruct::Builder results) {
  if (call == "status") {
    auto view = results.init("job").as<capnp::DynamicStruct>();
    view.set("id", params.get("job").as<std::uint64_t>());
    view.set("name", "from another age");
    view.set("state", "held");
  } else if (call == "submit") {
    const auto submission = params.get("submission").as<capnp::DynamicStruct>();
    auto jobs = results.init("submitted").as<capnp::DynamicStruct>().init("jobs", 1);
    jobs.as<capnp::DynamicList>().set(0,
                                      40 + submission.get("jobs").as<capnp::DynamicList>().size());
  } else {
    auto refusal = results.init("refusal").as<capnp::DynamicStruct>();
    refusal.set("kind", "conflict");
    refusal.set("sentence", capnp::Text::Reader(call));
  }
}

void expect_to_be_understood(Client& client) {
  const JobView view = client.status({7});
  EXPECT_EQ(view.id.value, 7U);
  EXPECT_EQ(view.name, "from another age");
  EXPECT_EQ(view.left_s, std::nullopt);
  EXPECT_EQ(client.submit({.key = "k", .jobs = {{.request = "r"}, {.request = "s"}}}).jobs,
            std::vector<JobId>{{42}});
  try {
    client.hold(Target::of(JobId{1}));
    ADD_FAILURE() << "was not refused";
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.refusal().kind, RefusalKind::conflict);
    EXPECT_EQ(error.refusal().sentence, "hold");
  }
}

TEST_F(VersionsTest, TodaysClientSpeaksWithTheFirstServer) {
  // Goal: today's client understands the first version's answers, and says so of a call that the
  // server does not know. Method: a service by the first schema; one without the call `stop`.
  {
    OtherServer server(text_of(k_first), socket(), answer_as_of_old);
    server.wait_for_start();
    Client client(socket());
    expect_to_be_understood(client);
  }
  std::string without = text_of(k_first);
  without = without.substr(0, without.find("  stop @15 ()")) +
            without.substr(without.find("}\n\ninterface File"));
  OtherServer server(without, socket(), answer_as_of_old);
  server.wait_for_start();
  Client client(socket());
  try {
    client.stop();
    ADD_FAILURE() << "was not refused";
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.refusal().kind, RefusalKind::not_found);
    EXPECT_NE(error.refusal().sentence.find("older"), std::string::npos);
  }
  expect_to_be_understood(client);
}

TEST_F(VersionsTest, TodaysClientSpeaksWithAFutureServer) {
  // Goal: what a newer server adds is left aside, its new values are told as unknown. Method: a
  // service by the future's schema that uses all of them.
  OtherServer server(future_text(), socket(),
                     [](kj::StringPtr call, capnp::DynamicStruct::Reader params,
                        capnp::DynamicStruct::Builder results) {
                       answer_as_of_old(call, params, results);
                       if (call == "status") {
                         auto view = results.get("job").as<capnp::DynamicStruct>();
                         view.set("nextView", "new");
                         view.set("nextNumber", 8);
                         if (params.get("job").as<std::uint64_t>() == 8)
                           view.set("state", "nextState");
                       } else if (call == "drain") {
                         results.get("refusal").as<capnp::DynamicStruct>().set("kind", "nextKind");
                       }
                     });
  server.wait_for_start();
  Client client(socket());
  expect_to_be_understood(client);
  EXPECT_EQ(client.status({7}).state, JobState::held);
  EXPECT_EQ(client.status({8}).state, JobState::unknown);
  try {
    client.drain();
    ADD_FAILURE() << "was not refused";
  } catch (const RefusedError& error) {
    EXPECT_EQ(error.refusal().kind, RefusalKind::unknown);
    EXPECT_EQ(error.refusal().sentence, "drain");
  }
}

}  // namespace
}  // namespace sleight::rpc
