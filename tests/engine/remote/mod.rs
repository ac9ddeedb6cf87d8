//! A cache that machines share: what one baked the others fetch, and nothing that goes wrong there changes a result.

mod server;

use super::{Bench, counts, ok, squares, support::*, tree};
use farfield::{
    engine::{
        bake::{Options, Report, bake},
        events::{Event, Events},
        plan::Plan,
        remote::{RemoteOptions, Traffic},
    },
    math::Stop,
};
use serde_json::json;
use server::{Mood, Server};
use std::{
    collections::BTreeMap,
    fs,
    path::Path,
    sync::Mutex,
    time::{Duration, Instant},
};

/// The texts of warnings.
#[derive(Default)]
struct Warnings(Mutex<Vec<String>>);

impl Events for Warnings {
    fn event(&self, event: &Event) {
        if let Event::Warning { text, .. } = event {
            self.0.lock().unwrap().push((*text).to_owned());
        }
    }
}

fn folder(path: &Path, write: bool) -> RemoteOptions {
    RemoteOptions { url: path.to_str().unwrap().to_owned(), write, settings: BTreeMap::new() }
}

fn bucket(endpoint: &str, write: bool) -> RemoteOptions {
    let settings = [("AWS_ENDPOINT_URL", endpoint), ("AWS_ACCESS_KEY_ID", "me"), ("AWS_SECRET_ACCESS_KEY", "secret")];
    let settings = settings.map(|(name, value)| (name.to_owned(), value.to_owned())).into();
    RemoteOptions { url: "s3://bucket/some/prefix".to_owned(), write, settings }
}

/// Bakes with a second level; what was warned of.
fn with(t: &Bench, plan: &Plan, remote: &RemoteOptions, change: impl FnOnce(&mut Options)) -> (Report, Vec<String>) {
    let warnings = Warnings::default();
    let mut options = Options { remote: Some(remote.clone()), ..t.options() };
    change(&mut options);
    let report = bake(plan, &options, &Stop::default(), &warnings).unwrap();
    ok(&report);
    let told = warnings.0.into_inner().unwrap();
    assert_eq!(told.len(), report.warnings, "{told:?}");
    (report, told)
}

/// The same where nothing is to be warned of.
fn quiet(t: &Bench, plan: &Plan, remote: &RemoteOptions) -> Report {
    let (report, told) = with(t, plan, remote, |_| {});
    assert_eq!(told, Vec::<String>::new());
    report
}

fn traffic(r: &Report) -> Traffic {
    r.remote.unwrap()
}

/// Small values and large ones.
fn plan() -> Plan {
    squares(&[1, 2, 3], 50_000)
}

/// What every kind of second level must do.
fn is_shared(write: &RemoteOptions, read: &RemoteOptions) {
    let (a, b) = (Bench::new(), Bench::new());
    let first = quiet(&a, &plan(), write);
    assert_eq!((first.runs(), traffic(&first).stored, traffic(&first).fetched), (6, 6, 0));
    assert!(traffic(&first).stored_bytes > 150_000);
    let second = quiet(&b, &plan(), read);
    assert_eq!((second.runs(), second.hits(), traffic(&second).fetched), (0, 6, 6));
    assert!(traffic(&second).fetched_bytes < 10_000, "what nobody needs stays there");
    assert_eq!(traffic(&second).stored, 0);
    assert_eq!(tree(&a.path("out")), tree(&b.path("out")));
    assert!(b.verify().is_clean());
    assert_eq!(traffic(&quiet(&b, &plan(), read)), Traffic::default(), "the local cache comes first");
    // What a changed consumer needs comes then.
    let (r, told) = with(&b, &plan(), read, |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(&r)["square"], counts(&r)["sum"], told.len()), ((3, 0), (0, 1), 0));
    assert!(traffic(&r).fetched_bytes > 150_000);
    assert!(b.verify().is_clean());
    assert_eq!(tree(&a.path("out")), tree(&b.path("out")));
}

#[test]
fn what_one_bakes_the_other_fetches_from_a_folder() {
    let t = Bench::new();
    let at = t.path("shared");
    is_shared(&folder(&at, true), &folder(&at, false));
    let url = format!("file://{}", at.display());
    assert_eq!(quiet(&t, &plan(), &RemoteOptions { url, ..folder(&at, false) }).runs(), 0);
}

#[test]
fn what_one_bakes_the_other_fetches_from_a_bucket() {
    let server = Server::start();
    is_shared(&bucket(&server.endpoint, true), &bucket(&server.endpoint, false));
    assert!(server.objects().keys().all(|name| name.starts_with("/bucket/some/prefix/v1/")));
}

/// Against a real server, whose address the variable says: `moto_server`, MinIO, …
#[test]
fn what_one_bakes_the_other_fetches_from_a_real_server() {
    let Ok(endpoint) = std::env::var("FARFIELD_TEST_S3") else {
        eprintln!("FARFIELD_TEST_S3 names no server: not tried");
        return;
    };
    let name = format!("farfield-{}", std::process::id());
    server::make_bucket(&endpoint, &name);
    let at = |write| RemoteOptions { url: format!("s3://{name}/a/b"), ..bucket(&endpoint, write) };
    is_shared(&at(true), &at(false));
    let missing = RemoteOptions { url: "s3://there-is-no-such-bucket/a".to_owned(), ..at(true) };
    let (r, told) = with(&Bench::new(), &plan(), &missing, |_| {});
    assert_eq!((r.runs(), told.len()), (6, 1));
    assert!(told[0].contains("NoSuchBucket"), "{told:?}");
}

#[test]
fn every_object_may_be_damaged_or_gone() {
    let t = Bench::new();
    let at = t.path("shared");
    quiet(&t, &plan(), &folder(&at, true));
    let (good, out) = (tree(&at), tree(&t.path("out")));
    assert!(good.len() >= 9, "six results, and large values");
    let mut noticed = 0;
    for (name, bytes) in &good {
        let flipped = || {
            let mut bytes = bytes.clone();
            let at = bytes.len() / 2;
            bytes[at] ^= 1;
            bytes
        };
        for damaged in [Some(flipped()), Some(bytes[..bytes.len() / 2].to_vec()), Some(Vec::new()), None] {
            match &damaged {
                Some(bytes) => fs::write(at.join(name), bytes).unwrap(),
                None => fs::remove_file(at.join(name)).unwrap(),
            }
            let other = Bench::new();
            // All values are needed once the sum runs again.
            let (r, told) = with(&other, &plan(), &folder(&at, true), |o| o.force = vec!["sum".into()]);
            assert_eq!(tree(&other.path("out")), out, "{name}");
            assert!(other.verify().is_clean());
            if damaged.is_none() {
                assert_eq!(told, Vec::<String>::new(), "{name}");
            } else if r.runs() > 1 {
                assert_eq!(told.len(), 1, "{name}: {told:?}");
                assert!(told[0].contains(name) && told[0].contains("damaged"), "{told:?}");
                noticed += 1;
            }
            // Who made it again has put a sound one in its place.
            if r.runs() > 1 {
                assert_eq!(quiet(&Bench::new(), &plan(), &folder(&at, false)).runs(), 0, "{name}");
            }
            fs::write(at.join(name), bytes).unwrap();
        }
    }
    assert!(noticed >= 20, "{noticed}");
}

#[test]
fn two_may_write_at_once() {
    let (t, server) = (Bench::new(), Server::start());
    let mut b = Builder::default();
    let many = b.node::<MakeMany>("many", json!({ "count": 200, "changed": -1 }), &[]);
    let square = b.node::<Square>("square", json!({ "pad": 20_000 }), &[From::Node(many)]);
    let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
    b.file("sum.txt", print);
    let plan = b.plan();
    for remote in [folder(&t.path("shared"), true), bucket(&server.endpoint, true)] {
        let (a, b) = (Bench::new(), Bench::new());
        std::thread::scope(|s| {
            s.spawn(|| quiet(&a, &plan, &remote));
            s.spawn(|| quiet(&b, &plan, &remote));
        });
        let c = Bench::new();
        let r = quiet(&c, &plan, &RemoteOptions { write: false, ..remote });
        assert_eq!((r.runs(), traffic(&r).fetched), (0, 203));
        for other in [&a, &b] {
            assert_eq!(tree(&other.path("out")), tree(&c.path("out")));
        }
    }
}

#[test]
fn a_server_that_fails_costs_one_warning() {
    let closed = {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        format!("http://{}", listener.local_addr().unwrap())
    };
    let expect = {
        let t = Bench::new();
        t.bake(&plan());
        tree(&t.path("out"))
    };
    let moods = [
        (None, "refused", Duration::from_secs(8)),
        (Some(Mood::RefusesAll), "InvalidAccessKeyId", Duration::from_secs(8)),
        (Some(Mood::NoBucket), "NoSuchBucket", Duration::from_secs(8)),
        (Some(Mood::Silent), "no answer within 10 s", Duration::from_secs(25)),
    ];
    std::thread::scope(|s| {
        for (mood, says, limit) in moods {
            let (closed, expect) = (&closed, &expect);
            s.spawn(move || {
                let server = Server::start();
                server.becomes(mood.unwrap_or(Mood::Well), 0);
                let endpoint = if mood.is_none() { closed } else { &server.endpoint };
                let (t, began) = (Bench::new(), Instant::now());
                let (r, told) = with(&t, &plan(), &bucket(endpoint, true), |_| {});
                assert_eq!((r.runs(), told.len()), (6, 1), "{mood:?}: {told:?}");
                assert!(told[0].contains(says) && told[0].contains("goes on with the local cache"), "{told:?}");
                assert!(began.elapsed() < limit, "{mood:?}: {:?}", began.elapsed());
                assert_eq!(tree(&t.path("out")), *expect);
                assert!(t.verify().is_clean());
            });
        }
    });
}

#[test]
fn what_cannot_be_written_is_read() {
    let server = Server::start();
    server.becomes(Mood::RefusesWrites, 0);
    let (t, remote) = (Bench::new(), bucket(&server.endpoint, true));
    let (r, told) = with(&t, &plan(), &remote, |_| {});
    assert_eq!((r.runs(), told.len()), (6, 1), "{told:?}");
    assert!(told[0].contains("takes no results") && told[0].contains("AccessDenied"), "{told:?}");
    assert!(told[0].contains("it is still read"), "{told:?}");
    assert!(server.objects().is_empty());
    // All but what depends on the fourth number is there.
    server.becomes(Mood::Well, 0);
    quiet(&Bench::new(), &plan(), &remote);
    server.becomes(Mood::RefusesWrites, 0);
    let (r, told) = with(&Bench::new(), &squares(&[1, 2, 3, 4], 50_000), &remote, |_| {});
    assert_eq!(counts(&r)["square"], (3, 1));
    assert_eq!(told.len(), 1, "{told:?}");
}

#[test]
fn a_server_may_die_at_any_request() {
    let server = Server::start();
    let (t, remote) = (Bench::new(), bucket(&server.endpoint, true));
    quiet(&t, &plan(), &remote);
    let out = tree(&t.path("out"));
    let before = server.requests();
    quiet(&Bench::new(), &plan(), &remote);
    let reads = server.requests() - before;
    assert!(reads >= 6);
    for patience in 0..=reads {
        let other = Bench::new();
        server.becomes(Mood::Dying, patience);
        let (r, told) = with(&other, &plan(), &remote, |o| o.force = vec!["sum".into()]);
        assert_eq!(tree(&other.path("out")), out, "{patience}");
        assert!(r.runs() >= 1 && told.len() <= 1, "{patience}: {told:?}");
        assert!(patience > 0 || r.runs() == 6 && told.len() == 1, "{told:?}");
        assert!(other.verify().is_clean());
        server.becomes(Mood::Well, 0);
        // What did not arrive the first time arrives now.
        assert_eq!(quiet(&other, &plan(), &remote).runs(), 0);
    }
    assert_eq!(quiet(&Bench::new(), &plan(), &remote).runs(), 0, "and nothing there is worse for it");
}

#[test]
fn what_dies_while_it_is_written_to_leads_to_no_half_results() {
    for patience in [0, 1, 2, 3, 5, 8, 13] {
        let server = Server::start();
        let (t, remote) = (Bench::new(), bucket(&server.endpoint, true));
        server.becomes(Mood::Dying, patience);
        with(&t, &plan(), &remote, |_| {});
        server.becomes(Mood::Well, 0);
        let other = Bench::new();
        let (r, told) = with(&other, &plan(), &remote, |o| o.force = vec!["sum".into()]);
        assert_eq!((tree(&other.path("out")), told.len()), (tree(&t.path("out")), 0), "{told:?}");
        assert_eq!(counts(&r)["sum"], (0, 1));
    }
}

#[test]
fn results_that_read_other_files_are_told_apart() {
    let t = Bench::new();
    let (at, source) = (t.path("shared"), t.path("n.txt"));
    let mut b = Builder::default();
    let n = b.node::<Source>("source", json!({ "path": source }), &[]);
    let print = b.node::<Print>("print", json!({}), &[From::Node(n)]);
    b.file("n.txt", print);
    let plan = b.plan();
    fs::write(&source, "5").unwrap();
    let bake = |extra: Option<&str>| {
        match extra {
            Some(text) => fs::write(t.path("extra.txt"), text).unwrap(),
            None => drop(fs::remove_file(t.path("extra.txt"))),
        }
        let other = Bench::new();
        let runs = quiet(&other, &plan, &folder(&at, true)).runs();
        (runs, other.file("n.txt").trim().to_owned())
    };
    assert_eq!(bake(None), (2, "5".to_owned()));
    assert_eq!(bake(Some("2")), (2, "7".to_owned()));
    for (extra, sum) in [(None, "5"), (Some("2"), "7")] {
        assert_eq!(bake(extra), (0, sum.to_owned()));
    }
}

#[test]
fn options_keep_their_meaning() {
    let t = Bench::new();
    let at = t.path("shared");
    quiet(&t, &plan(), &folder(&at, true));
    let before = tree(&at);
    let other = Bench::new();
    let (r, _) = with(&other, &plan(), &folder(&at, true), |o| o.dry_run = true);
    assert!(r.remote.is_none() && !other.path("cache").exists(), "a dry run asks nobody");
    let (r, told) = with(&other, &plan(), &folder(&at, true), |o| o.audit = 1.0);
    assert_eq!((r.runs(), told.len(), r.audit.unwrap().runs, r.audit.unwrap().different_runs), (6, 0, 6, 0));
    let all = ["list", "square", "sum", "print"].map(str::to_owned);
    let (r, told) = with(&Bench::new(), &plan(), &folder(&at, true), |o| o.force = all.into());
    assert_eq!((r.runs(), traffic(&r).fetched, told.len()), (6, 0, 0));
    assert_eq!(tree(&at), before, "the first result stays");
}

#[test]
fn values_of_transient_nodes_are_made_where_they_are_needed() {
    let t = Bench::new();
    let at = t.path("shared");
    let plan = || {
        let mut b = Builder::default();
        let list = b.node::<MakeList>("list", json!({ "names": ["a", "b"], "values": [3, 4] }), &[]);
        let square = b.node::<Square>("square", json!({ "pad": 50_000 }), &[From::Node(list)]);
        let sum = b.node::<Sum>("sum", json!({}), &[From::Node(square)]);
        let print = b.node::<Print>("print", json!({}), &[From::Node(sum)]);
        b.transient(square);
        b.file("sum.txt", print);
        b.plan()
    };
    quiet(&t, &plan(), &folder(&at, true));
    assert!(tree(&at).keys().all(|name| name.starts_with("v1/run/")), "no large value is kept");
    let other = Bench::new();
    assert_eq!(quiet(&other, &plan(), &folder(&at, false)).runs(), 0);
    let (r, told) = with(&other, &plan(), &folder(&at, false), |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(&r)["list"], counts(&r)["square"], told.len()), ((1, 0), (0, 2), 0));
    assert_eq!(other.file("sum.txt"), "25\n");
}

#[test]
fn a_lost_local_value_is_fetched_and_without_a_second_level_made() {
    let t = Bench::new();
    let at = t.path("shared");
    quiet(&t, &plan(), &folder(&at, true));
    let other = Bench::new();
    quiet(&other, &plan(), &folder(&at, false));
    // Never fetched, and the second level is gone: made here, without a word of damage.
    let r = other.bake_with(&plan(), |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(ok(&r))["square"], r.warnings), ((0, 3), 0));
    for (name, _) in tree(&other.path("cache/values")) {
        fs::remove_file(other.path("cache/values").join(name)).unwrap();
    }
    let (r, told) = with(&other, &plan(), &folder(&at, false), |o| o.force = vec!["sum".into()]);
    assert_eq!((counts(&r)["square"], told.len()), ((3, 0), 3), "one warning for each lost value: {told:?}");
    assert!(other.verify().is_clean());
}

#[test]
fn addresses_that_cannot_be_are_refused_before_anything_runs() {
    let t = Bench::new();
    fs::write(t.path("file"), "").unwrap();
    t.bake(&plan());
    let text = |url: &str, write: bool| {
        let remote = Some(RemoteOptions { url: url.to_owned(), write, settings: BTreeMap::new() });
        let e = bake(&plan(), &Options { remote, ..t.options() }, &Stop::default(), &Warnings::default()).unwrap_err();
        assert_eq!(e.exit_code(), 2);
        e.to_string()
    };
    assert!(text("ftp://x/y", false).contains("expected s3://BUCKET/PREFIX"));
    assert!(text(t.path("file").to_str().unwrap(), true).contains("it is a file"));
    assert!(text(t.path("absent").to_str().unwrap(), false).contains("no such folder"));
    assert!(text(t.path("cache").to_str().unwrap(), true).contains("local cache"));
}
