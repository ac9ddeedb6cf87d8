//! `farfield watch`: a bake after every save.
//!
//! One thread waits for what happens (saves, keys, the end of a bake) and decides; bakes run on another, one at a time.
//! `files` decides what was saved, `turn` what is to be done.

mod files;
mod folders;
mod turn;

use super::{
    Done, Exit,
    backend::Chosen,
    bake, batch, interrupt,
    pipeline::{self, PipelineArgs},
    quantity::show_seconds,
    terminal::{fill, say},
};
use crate::{
    engine::{
        bake::{Outcome, Report},
        pipeline::Problems,
        plan::Plan,
        registry::Registry,
        why::why,
    },
    math::Stop,
};
use files::{Here, News, Watched};
use folders::{Folders, QUIET};
use std::{
    io::IsTerminal as _,
    panic::{AssertUnwindSafe, catch_unwind},
    path::{Path, PathBuf},
    sync::mpsc::{self, RecvTimeoutError, Sender},
    thread::Scope,
    time::{Duration, SystemTime},
};
use turn::{Step, Turn};

/// Bakes a pipeline, and again whenever its file, a base or a file that it reads is saved
///
/// A broken file leaves the last good output as it is. Keys, each with Enter: r bakes now, w tells what ran and why, q quits. Ends with 0
/// after q, with 130 when it is interrupted, and with 2 where there is nothing to watch.
#[derive(clap::Args)]
// Groups have the names of their structs, and that of `bake` has the same.
#[group(skip)]
pub struct Args {
    #[command(flatten)]
    bake: bake::Args,
    /// After a save bakes with this first, besides --set, and then as the file says: `--quick views=8` gives an answer
    /// from few views soon, and that from all of them later. May be given several times
    #[arg(long, value_name = "NAME=VALUE")]
    quick: Vec<String>,
}

impl Args {
    /// The pipeline as it is asked for, or for the quick answer.
    fn pipeline(&self, quick: bool) -> PipelineArgs {
        self.bake.pipeline.with(if quick { &self.quick } else { &[] })
    }
}

/// What happens.
enum Message {
    /// Something happened at these paths, and no more.
    Touched(Vec<PathBuf>),
    Key(Key),
    Ended(Box<Ended>),
    Interrupted,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Key {
    Bake,
    Why,
    Quit,
    Unknown,
}

/// How a bake ended.
struct Ended {
    /// What it used, as far as it came.
    files: Vec<PathBuf>,
    /// Absent where no bake was possible; what there is to say has been said.
    result: Option<(Plan, Report)>,
    /// When it began, nanoseconds since 1970.
    began: i128,
}

/// What no event tells (drives of other machines, a folder that another took the place of) is found so often.
const LOOK_EVERY: Duration = Duration::from_secs(2);

/// Times of saving that are longer ago, or in the future, are another clock's.
const SAVED_WITHIN: i128 = 5_000_000_000;

const KEYS: &str = "keys, each with Enter: r bakes now, w tells what ran and why, q quits";

pub fn run(args: &Args, registry: &Registry) -> Done {
    let began = now();
    let first = first(args, registry)?;
    let backend = args.bake.backend.open()?;
    let (tell, messages) = mpsc::channel();
    let told = tell.clone();
    // Whoever would listen has gone only when the program ends.
    interrupt::on(move || drop(told.send(Message::Interrupted)))?;
    let told = tell.clone();
    let folders = Folders::new(move |paths| drop(told.send(Message::Touched(paths))));
    let folders = folders.map_err(|e| Exit::say(1, format!("cannot watch files: {e}")))?;
    let keys = std::io::stdin().is_terminal();
    let mut session = Session {
        args,
        registry,
        backend: &backend,
        tell,
        watched: Watched::default(),
        folders,
        turn: Turn::default(),
        stop: Stop::default(),
        saved: None,
        last: None,
        baked: false,
        keys,
    };
    session.learn(&first, false, began);
    if keys {
        let tell = session.tell.clone();
        std::thread::spawn(move || listen(std::io::stdin().lines().map_while(Result::ok), &tell));
    }
    let code = std::thread::scope(|scope| {
        let mut step = session.turn.wanted();
        loop {
            match step {
                Step::Nothing => {}
                Step::Bake => session.start(scope),
                Step::Stop => session.stop.set(),
                Step::Leave(code) => return code,
            }
            step = match messages.recv_timeout(LOOK_EVERY) {
                Ok(message) => session.take(message),
                Err(RecvTimeoutError::Timeout) => session.look_around(),
                // The session holds a sender.
                Err(RecvTimeoutError::Disconnected) => Step::Leave(1),
            };
        }
    });
    if code == 0 { Ok(()) } else { Err(Exit(code)) }
}

/// The one pipeline that `args` ask for, or what is wrong with it: of a batch a single row.
fn one(args: &Args, quick: bool, registry: &Registry) -> Result<Result<Plan, Problems>, Exit> {
    let pipeline = args.pipeline(quick);
    let plan = match pipeline.read(registry)? {
        Ok(plan) if !plan.rows.is_empty() => plan,
        other => return Ok(other),
    };
    match &batch::chosen(&args.bake, &plan)?[..] {
        [row] => pipeline.read_row(*row, registry),
        rows => Err(Exit::say(2, format!("[batch] asks for {} bakes; name one of them with --row", rows.len()))),
    }
}

/// The files to watch before the first bake; an error where there are none.
fn first(args: &Args, registry: &Registry) -> Result<Vec<PathBuf>, Exit> {
    let files = match one(args, false, registry)? {
        Ok(plan) if plan.texts.is_empty() && plan.sources.iter().all(|s| s.starts_with("builtin:")) => {
            let what = format!(
                "nothing to watch: the stock pipeline {} reads no file; `farfield init SCENE` writes a pipeline file",
                plan.name
            );
            return Err(Exit::say(2, what));
        }
        Ok(plan) => {
            if !args.quick.is_empty()
                && let Err(problems) = one(args, true, registry)?
            {
                return Err(pipeline::report(&problems));
            }
            plan.texts
        }
        // The bake will say what is wrong.
        Err(problems) if !problems.sources.is_empty() => problems.files(),
        Err(problems) => return Err(pipeline::report(&problems)),
    };
    Ok(files)
}

struct Session<'a> {
    args: &'a Args,
    registry: &'a Registry,
    backend: &'a Chosen,
    tell: Sender<Message>,
    watched: Watched,
    folders: Folders,
    turn: Turn,
    /// Of the bake that runs.
    stop: Stop,
    /// When what the running or next bake is for was saved, nanoseconds since 1970.
    saved: Option<i128>,
    /// The last bake that was not stopped.
    last: Option<(Plan, Report)>,
    /// Whether any bake gave an output.
    baked: bool,
    keys: bool,
}

impl<'a> Session<'a> {
    fn start<'s>(&mut self, scope: &'s Scope<'s, 'a>) {
        self.stop = Stop::default();
        let (args, registry, backend) = (self.args, self.registry, self.backend);
        let (stop, tell, saved) = (self.stop.clone(), self.tell.clone(), self.saved);
        scope.spawn(move || {
            let began = now();
            let ended = catch_unwind(AssertUnwindSafe(|| {
                let attempt = |quick| attempt(args, quick, registry, backend, &stop, began);
                if args.quick.is_empty() {
                    return attempt(false);
                }
                let first = attempt(true);
                // What stops or is wrong is so for the whole bake too.
                if !matches!(&first.result, Some((_, r)) if matches!(r.outcome, Outcome::Baked | Outcome::NotMet)) {
                    return first;
                }
                let since = show_seconds((now() - saved.unwrap_or(began)) as f64 * 1e-9);
                say(format_args!("{since} to the quick answer, with {}; all of it follows", args.quick.join(", ")));
                attempt(false)
            }));
            let ended = ended.unwrap_or_else(|_| {
                say("error: the bake broke off; this is a mistake in farfield");
                Ended { files: Vec::new(), result: None, began }
            });
            let _ = tell.send(Message::Ended(Box::new(ended)));
        });
    }

    fn take(&mut self, message: Message) -> Step {
        match message {
            Message::Touched(paths) => {
                let news = self.watched.look(&paths, &Here);
                self.hear(news)
            }
            Message::Key(Key::Bake) if self.turn.is_baking() => {
                say("a bake is running already");
                Step::Nothing
            }
            Message::Key(Key::Bake) => {
                self.saved = None;
                self.turn.wanted()
            }
            Message::Key(Key::Why) => {
                self.why();
                Step::Nothing
            }
            Message::Key(Key::Quit) => self.turn.leave(0),
            Message::Key(Key::Unknown) => {
                say(KEYS);
                Step::Nothing
            }
            Message::Interrupted => {
                if self.turn.is_baking() {
                    say("interrupted: the bake stops (a second Ctrl-C leaves at once)");
                }
                self.turn.leave(130)
            }
            Message::Ended(ended) => self.end(*ended),
        }
    }

    /// Nothing was heard for a while.
    fn look_around(&mut self) -> Step {
        self.folders.follow(&self.watched.folders());
        if !self.watched.differ(&Here) {
            return Step::Nothing;
        }
        // It may be in the middle of being saved.
        std::thread::sleep(QUIET);
        let news = self.watched.look_at_all(&Here);
        self.hear(news)
    }

    fn hear(&mut self, news: News) -> Step {
        for path in &news.gone {
            say(fill(&format!("{} is gone; {}, and it is watched for", shown(path), self.kept())));
        }
        for path in &news.back {
            say(format_args!("{} is there", shown(path)));
            self.folders.renew(path);
        }
        if !news.back.is_empty() {
            self.folders.follow(&self.watched.folders());
        }
        let stops = if self.turn.is_baking() { "; the bake of what was there before stops" } else { "" };
        for path in &news.changed {
            say(format_args!("{} was saved{stops}", shown(path)));
        }
        if !news.call_for_a_bake() {
            return Step::Nothing;
        }
        let noticed = now();
        self.saved = news.saved.filter(|at| (0..=SAVED_WITHIN).contains(&(noticed - at))).or(Some(noticed));
        self.turn.wanted()
    }

    fn learn(&mut self, files: &[PathBuf], all: bool, began: i128) -> News {
        let news = self.watched.learn(files, all, began, &Here);
        self.folders.follow(&self.watched.folders());
        news
    }

    fn end(&mut self, ended: Ended) -> Step {
        let Ended { files, result, began } = ended;
        let outcome = result.as_ref().map(|(_, report)| report.outcome);
        let whole = matches!(outcome, Some(Outcome::Baked | Outcome::NotMet));
        let news = self.learn(&files, whole, began);
        if !self.turn.is_stale() {
            self.close(&result);
            if result.is_some() {
                self.last = result;
            }
        }
        match self.turn.ended() {
            Step::Nothing => self.hear(news),
            step => step,
        }
    }

    /// The last words on a bake that came to its end.
    fn close(&mut self, result: &Option<(Plan, Report)>) {
        let since = self.saved.take().map(|at| show_seconds((now() - at) as f64 * 1e-9));
        match result {
            Some((_, report)) if report.outcome == Outcome::Baked => {
                self.baked = true;
                if let Some(time) = since {
                    say(format_args!("{time} from the save to the finished output"));
                }
            }
            _ => say(format_args!("{}; the next save bakes again", self.kept())),
        }
        let count = self.watched.len();
        say(format_args!("watching {count} file{}", if count == 1 { "" } else { "s" }));
        if std::mem::take(&mut self.keys) {
            say(KEYS);
        }
    }

    fn kept(&self) -> &'static str {
        if self.baked { "the last good output stays" } else { "no bake has succeeded yet" }
    }

    /// What ran in the last bake, and for which reason.
    fn why(&self) {
        if self.turn.is_baking() {
            return say("a bake is running");
        }
        let Some((plan, report)) = &self.last else { return say("no bake has come to its end yet") };
        let mut ran = report.nodes.iter().filter(|node| node.runs > 0).peekable();
        if ran.peek().is_none() {
            return say(format_args!("nothing ran in the last bake of {}: {} hits", plan.name, report.hits()));
        }
        let Ok(options) = self.args.bake.options(plan, self.backend) else { return };
        for node in ran {
            match why(plan, &options, &node.name) {
                Ok(answer) => say(fill(answer.trim_end())),
                Err(e) => say(format_args!("error: {e}")),
            }
        }
    }
}

/// One bake, from the file to its summary.
fn attempt(args: &Args, quick: bool, registry: &Registry, backend: &Chosen, stop: &Stop, began: i128) -> Ended {
    let nothing = |files| Ended { files, result: None, began };
    let plan = match one(args, quick, registry) {
        Ok(Ok(plan)) => plan,
        Ok(Err(problems)) => {
            pipeline::report(&problems);
            return nothing(problems.files());
        }
        Err(Exit(_)) => return nothing(Vec::new()),
    };
    let mut files = plan.texts.clone();
    let report = args.bake.options(&plan, backend).and_then(|o| args.bake.bake(&plan, &o, backend, stop));
    let Ok(report) = report else { return nothing(files) };
    files.extend(report.files.iter().cloned());
    // Of a bake that was stopped nobody wants to read.
    if report.outcome != Outcome::Interrupted {
        // What cannot be written to standard output has been said.
        let _ = args.bake.tell(&plan, &report);
    }
    Ended { files, result: Some((plan, report)), began }
}

/// Reads keys until the end of the input, which is one too.
fn listen(lines: impl Iterator<Item = String>, tell: &Sender<Message>) {
    for line in lines {
        if let Some(key) = key(&line)
            && tell.send(Message::Key(key)).is_err()
        {
            return;
        }
    }
    let _ = tell.send(Message::Key(Key::Quit));
}

/// The key of a line; none in an empty one.
fn key(line: &str) -> Option<Key> {
    match line.trim() {
        "" => None,
        "r" => Some(Key::Bake),
        "w" => Some(Key::Why),
        "q" => Some(Key::Quit),
        _ => Some(Key::Unknown),
    }
}

/// A path from the working folder where it lies below it.
fn shown(path: &Path) -> String {
    let folder = std::env::current_dir().unwrap_or_default();
    path.strip_prefix(&folder).unwrap_or(path).display().to_string()
}

/// Nanoseconds since 1970.
fn now() -> i128 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |d| i128::try_from(d.as_nanos()).unwrap_or(i128::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_key_and_the_end_of_the_input_quits() {
        let (tell, heard) = mpsc::channel();
        listen(["r", "", " w ", "x"].into_iter().map(str::to_owned), &tell);
        drop(tell);
        let keys: Vec<Key> =
            heard.iter().filter_map(|m| if let Message::Key(k) = m { Some(k) } else { None }).collect();
        assert_eq!(keys, [Key::Bake, Key::Why, Key::Unknown, Key::Quit]);
    }
}
