//! What went wrong with a request, for people and for the decision whether to go on.

use object_store::Error;
use std::{error, io};

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// There is no such object.
    Absent,
    /// It is there already.
    Present,
    /// The store says no, and will say it again.
    Refused(String),
    /// No answer in time.
    Silent(String),
    Other(String),
}

impl Fault {
    pub fn of(e: &Error) -> Self {
        let text = text(e);
        match e {
            // The bucket itself is missing: nothing in it ever comes.
            Error::NotFound { .. } if text.contains("NoSuchBucket") => Self::Refused(text),
            Error::NotFound { .. } => Self::Absent,
            Error::AlreadyExists { .. } | Error::Precondition { .. } => Self::Present,
            Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => Self::Refused(text),
            Error::InvalidPath { .. } => Self::Refused(text),
            _ => match io_kind(e) {
                Some(
                    io::ErrorKind::PermissionDenied
                    | io::ErrorKind::ReadOnlyFilesystem
                    | io::ErrorKind::StorageFull
                    | io::ErrorKind::QuotaExceeded,
                ) => Self::Refused(text),
                Some(io::ErrorKind::TimedOut) => Self::Silent(text),
                _ => Self::Other(text),
            },
        }
    }

    pub fn text(&self) -> &str {
        match self {
            Self::Absent => "there is no such object",
            Self::Present => "it is there already",
            Self::Refused(text) | Self::Silent(text) | Self::Other(text) => text,
        }
    }
}

/// The errors that caused `e`, it first.
fn chain(e: &Error) -> impl Iterator<Item = &(dyn error::Error + 'static)> {
    std::iter::successors(Some(e as &(dyn error::Error + 'static)), |e| e.source())
}

fn io_kind(e: &Error) -> Option<io::ErrorKind> {
    chain(e).filter_map(|e| e.downcast_ref::<io::Error>()).last().map(io::Error::kind)
}

/// The cause, in a line: what the server says of itself, or the innermost error.
pub fn text(e: &Error) -> String {
    let whole = e.to_string();
    let part = |tag: &str| {
        let (_, rest) = whole.split_once(&format!("<{tag}>"))?;
        rest.split_once(&format!("</{tag}>")).map(|(text, _)| text.trim())
    };
    let mut text = match (part("Code"), part("Message")) {
        (Some(code), Some(message)) => format!("{code}: {message}"),
        (Some(code), None) => code.to_owned(),
        _ => match status(&whole) {
            Some(status) => format!("the server answered {status}"),
            None => chain(e).last().map(ToString::to_string).unwrap_or_default(),
        },
    };
    // It comes from a server: one line of ordinary characters, and not a page.
    text.retain(|c| !c.is_control());
    if let Some((at, _)) = text.char_indices().nth(300) {
        text.truncate(at);
        text += "…";
    }
    text
}

/// The status in the text of an answer that says nothing else.
fn status(whole: &str) -> Option<&str> {
    let (_, rest) = whole.split_once("status code: ")?;
    Some(rest.split(": ").next().unwrap_or(rest).trim_end_matches(':').trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_says_what_the_server_said() {
        let body = "Server returned non-2xx status code: 403 Forbidden: <Error><Code>AccessDenied</Code>\
                    <Message>Access\u{1b}[31m Denied</Message></Error>";
        let e = Error::PermissionDenied { path: "a".into(), source: body.into() };
        assert_eq!(Fault::of(&e), Fault::Refused("AccessDenied: Access[31m Denied".to_owned()));
        let e = Error::NotFound { path: "a".into(), source: "<Code>NoSuchKey</Code>".into() };
        assert_eq!(Fault::of(&e), Fault::Absent);
        let e = Error::NotFound { path: "a".into(), source: "<Code>NoSuchBucket</Code>".into() };
        assert!(matches!(Fault::of(&e), Fault::Refused(_)));
        let source = "Server returned non-2xx status code: 500 Internal Server Error: ".into();
        let e = Error::Generic { store: "S3", source };
        assert_eq!(text(&e), "the server answered 500 Internal Server Error");
        let full = io::Error::new(io::ErrorKind::StorageFull, "no space");
        let e = Error::Generic { store: "LocalFileSystem", source: Box::new(full) };
        assert_eq!(Fault::of(&e), Fault::Refused("no space".to_owned()));
        let e = Error::Generic { store: "S3", source: "x".repeat(5000).into() };
        assert_eq!(text(&e).chars().count(), 301);
    }
}
