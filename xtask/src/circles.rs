//! `cargo xtask circles`: modules of a folder that use each other in a circle.
//!
//! The modules of each folder are the nodes of a graph, and a path to another module, in a `use` or in the code, is
//! an edge; names that a module re-exports count for the module that defines them. Circles that are
//! accepted are listed with their reasons. Paths in tests and in comments do not count.

use crate::workspace::Workspace;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Modules of a folder that may use each other.
struct Accepted {
    /// The crate and the folder, as in `emitree/projection`.
    folder: &'static str,
    modules: &'static [&'static str],
    /// Why they do.
    reason: &'static str,
}

const ACCEPTED: &[Accepted] = &[
    Accepted {
        folder: "emitree/projection",
        modules: &["charts", "map", "view_geometry"],
        reason: "a projection is a chart or has several, of the geometry of its view",
    },
    Accepted {
        folder: "emitree-io/fits",
        modules: &["channels", "wcs"],
        reason: "an axis of channels is one of the axes of a file",
    },
    Accepted {
        folder: "emitree-io/grid",
        modules: &["error", "request"],
        reason: "errors name formats, and formats are chosen with errors",
    },
    Accepted {
        folder: "emitree-io/scene",
        modules: &["absorption", "emission", "radiometry", "tree"],
        reason: "the units of an emission and of an absorption coefficient are read with them",
    },
    Accepted {
        folder: "emitree-io/units",
        modules: &["parser", "unit"],
        reason: "a unit is parsed by a function of its type",
    },
    Accepted {
        folder: "emitree-models",
        modules: &["catalogue", "models"],
        reason: "a model describes itself in the terms of the catalogue, which lists all models",
    },
];

/// A module by its path in the crate; the root is empty.
type Module = Vec<String>;
/// Names that a module re-exports, with the paths that they stand for.
type Reexports = BTreeMap<(Module, String), Vec<String>>;

/// Finds circles in the folders of all crates.
pub(crate) fn run(workspace: &Workspace) -> Result<(), String> {
    let crates = fs::read_dir(workspace.path("crates")).map_err(|error| error.to_string())?;
    let crates = crates.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut sources: Vec<(String, String)> =
        crates.map(|name| (name.clone(), format!("crates/{name}/src"))).collect();
    for folder in ["python", "xtask"] {
        sources.push((folder.to_owned(), format!("{folder}/src")));
    }
    sources.sort();
    let mut found = Vec::new();
    for (name, folder) in sources {
        let mut files = BTreeMap::new();
        read(&workspace.path(&folder), &Module::new(), &mut files)?;
        found.extend(circles(&without_tests(files)).into_iter().map(|(folder, modules)| {
            let folder: Vec<String> = [vec![name.clone()], folder].concat();
            (folder.join("/"), modules)
        }));
    }
    let is_accepted = |folder: &str, modules: &[String]| {
        ACCEPTED.iter().any(|one| one.folder == folder && one.modules == modules)
    };
    let new = found.iter().filter(|(folder, modules)| !is_accepted(folder, modules));
    let mut lines: Vec<String> = new
        .map(|(folder, modules)| format!("{folder}: {} use each other", modules.join(", ")))
        .collect();
    let is_gone = |one: &&Accepted| {
        !found.iter().any(|(folder, modules)| one.folder == folder && one.modules == modules)
    };
    lines.extend(ACCEPTED.iter().filter(is_gone).map(|one| {
        let modules = one.modules.join(", ");
        format!("{}: {modules} are accepted ({}), and are no circle", one.folder, one.reason)
    }));
    if lines.is_empty() { Ok(()) } else { Err(lines.join("\n")) }
}

/// The modules of a folder, with their code.
fn read(
    folder: &Path,
    module: &Module,
    files: &mut BTreeMap<Module, String>,
) -> Result<(), String> {
    let in_folder = |error: std::io::Error| format!("{}: {error}", folder.display());
    for entry in fs::read_dir(folder).map_err(in_folder)? {
        let path = entry.map_err(in_folder)?.path();
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
        let inner: Module = match name.as_str() {
            "mod" | "lib" | "main" => module.clone(),
            _ => [module.clone(), vec![name]].concat(),
        };
        if path.is_dir() {
            read(&path, &inner, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).map_err(in_folder)?;
            files.insert(inner, text);
        }
    }
    Ok(())
}

/// The code of the modules that are not for tests alone.
fn without_tests(texts: BTreeMap<Module, String>) -> BTreeMap<Module, String> {
    const FOR_TESTS: &str = "#[cfg(test)]\nmod ";
    let declared = |(module, text): (&Module, &String)| {
        let names = text.split(FOR_TESTS).skip(1).filter_map(|rest| {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_')?;
            Some([module.clone(), vec![rest[..end].to_owned()]].concat())
        });
        names.collect::<Vec<_>>()
    };
    let for_tests: Vec<Module> = texts.iter().flat_map(declared).collect();
    let is_for_tests = |module: &Module| for_tests.iter().any(|test| module.starts_with(test));
    let kept = texts.into_iter().filter(|(module, _)| !is_for_tests(module));
    kept.map(|(module, text)| (module, code(&text))).collect()
}

/// A file without its tests and comments.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The circles of each folder.
fn circles(files: &BTreeMap<Module, String>) -> Vec<(Module, Vec<String>)> {
    let reexports = reexports(files);
    let mut edges: BTreeMap<Module, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
    for (module, code) in files {
        for path in paths(code) {
            let Some(target) = resolve(module, &path, files, &reexports, 0) else { continue };
            let common = module.iter().zip(&target).take_while(|(a, b)| a == b).count();
            if let (Some(from), Some(to)) = (module.get(common), target.get(common)) {
                let folder = edges.entry(module[..common].to_vec()).or_default();
                folder.entry(from.clone()).or_default().insert(to.clone());
            }
        }
    }
    let of_folder = |(folder, edges): (Module, BTreeMap<String, BTreeSet<String>>)| {
        components(&edges).into_iter().map(move |modules| (folder.clone(), modules))
    };
    edges.into_iter().flat_map(of_folder).collect()
}

/// Sets of more than one node, each of which can be reached from all others.
fn components(edges: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reached = |start: &String| {
        let (mut reached, mut next) = (BTreeSet::new(), vec![start]);
        while let Some(node) = next.pop() {
            for target in edges.get(node).into_iter().flatten() {
                if reached.insert(target.clone()) {
                    next.push(target);
                }
            }
        }
        reached
    };
    let all: BTreeMap<&String, BTreeSet<String>> =
        edges.keys().map(|node| (node, reached(node))).collect();
    let mut components = BTreeSet::new();
    for (node, reached) in &all {
        let is_mutual =
            |other: &&String| all.get(other).is_some_and(|from_other| from_other.contains(*node));
        let mutual: Vec<String> = reached.iter().filter(is_mutual).cloned().collect();
        if mutual.len() > 1 {
            components.insert(mutual);
        }
    }
    components.into_iter().collect()
}

/// The names that modules re-export.
fn reexports(files: &BTreeMap<Module, String>) -> Reexports {
    let mut reexports = Reexports::new();
    for (module, code) in files {
        for statement in statements(code, true) {
            for path in expanded(&statement) {
                if let Some(name) = path.last() {
                    reexports.insert((module.clone(), name.clone()), path.clone());
                }
            }
        }
    }
    reexports
}

/// The module that a path leads to from `module`; none if it is outside the crate.
fn resolve(
    module: &Module,
    path: &[String],
    files: &BTreeMap<Module, String>,
    reexports: &Reexports,
    depth: usize,
) -> Option<Module> {
    const MOST_REEXPORTS: usize = 6;
    let mut at = module.clone();
    let mut rest = path;
    match path.first().map(String::as_str)? {
        "crate" => (at, rest) = (Module::new(), &path[1..]),
        "self" => rest = &path[1..],
        "super" => {
            while rest.first().is_some_and(|word| word == "super") {
                at.pop();
                rest = &rest[1..];
            }
        }
        name => {
            let child = [at.clone(), vec![name.to_owned()]].concat();
            if !files.contains_key(&child)
                && !reexports.contains_key(&(at.clone(), name.to_owned()))
            {
                return None;
            }
        }
    }
    while let Some(name) = rest.first() {
        let child = [at.clone(), vec![name.clone()]].concat();
        if files.contains_key(&child) {
            (at, rest) = (child, &rest[1..]);
            continue;
        }
        let reexported = reexports.get(&(at.clone(), name.clone()));
        if let Some(path) = reexported.filter(|_| depth < MOST_REEXPORTS) {
            return resolve(&at, path, files, reexports, depth + 1).or(Some(at));
        }
        break;
    }
    Some(at)
}

/// All paths of a file that may lead to other modules.
fn paths(code: &str) -> Vec<Vec<String>> {
    let uses = statements(code, false);
    let mut paths: Vec<Vec<String>> = uses.iter().flat_map(|use_| expanded(use_)).collect();
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let words = code.split(|c| !is_word(c)).filter(|word| word.contains("::"));
    let paths_in_code = words.map(|word| {
        word.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect::<Vec<_>>()
    });
    let leads_inside = |path: &Vec<String>| {
        path.len() > 1
            && path.first().is_some_and(|word| word.chars().all(|c| c.is_lowercase() || c == '_'))
    };
    paths.extend(paths_in_code.filter(leads_inside));
    paths
}

/// The contents of `use` statements: of those that re-export, or of all others.
fn statements(code: &str, are_public: bool) -> Vec<String> {
    let mut statements = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find("use ") {
        let before = rest[..at].rsplit('\n').next().unwrap_or_default().trim();
        let is_statement =
            before.is_empty() || (before.starts_with("pub") && !before.contains(';'));
        let after = &rest[at + "use ".len()..];
        let end = after.find(';').unwrap_or(after.len());
        if is_statement && before.starts_with("pub") == are_public {
            statements.push(after[..end].to_owned());
        }
        rest = &after[if is_statement { end } else { 0 }..];
    }
    statements
}

/// The paths of a `use`: one for each name in its braces.
fn expanded(tree: &str) -> Vec<Vec<String>> {
    let words = |text: &str| -> Vec<String> {
        let path = text.split(" as ").next().unwrap_or_default();
        path.split("::").map(str::trim).filter(|word| !word.is_empty()).map(str::to_owned).collect()
    };
    let Some((base, inner)) = tree.split_once('{') else { return vec![words(tree)] };
    let base = words(base);
    let inner = inner.rsplit_once('}').map_or(inner, |(inner, _)| inner);
    let (mut parts, mut depth, mut start) = (Vec::new(), 0, 0);
    for (at, c) in inner.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&inner[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&inner[start..]);
    let parts = parts.into_iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(expanded).map(|path| [base.clone(), path].concat()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(texts: &[(&str, &str)]) -> BTreeMap<Module, String> {
        let module =
            |path: &str| path.split('/').filter(|p| !p.is_empty()).map(str::to_owned).collect();
        without_tests(texts.iter().map(|(path, text)| (module(path), (*text).to_owned())).collect())
    }

    fn names(texts: &[(&str, &str)]) -> Vec<String> {
        let found = circles(&files(texts)).into_iter();
        found
            .map(|(folder, modules)| format!("{}: {}", folder.join("/"), modules.join(" ")))
            .collect()
    }

    #[test]
    fn a_circle_of_three_is_found_and_a_chain_is_none() {
        let chain = [
            ("", "mod a; mod b; mod c;"),
            ("a", "use crate::b::B;"),
            ("b", "use super::c::{C, D};"),
            ("c", ""),
        ];
        assert_eq!(names(&chain), Vec::<String>::new());
        let mut circle = chain;
        circle[3] = ("c", "fn f() -> crate::a::A { crate::a::A }");
        assert_eq!(names(&circle), [": a b c"]);
    }

    #[test]
    fn folders_have_circles_of_their_own_and_outside_through_all_of_their_files() {
        let texts = [
            ("", ""),
            ("a", ""),
            ("a/x", "use super::y::Y;"),
            ("a/y", "use crate::a::x::{self, X};\nuse crate::b::B;"),
            ("b", "use crate::a::x::X;"),
        ];
        assert_eq!(names(&texts), [": a b", "a: x y"]);
    }

    #[test]
    fn reexported_names_count_for_the_module_that_has_them() {
        let texts = [
            ("", "pub use b::B;"),
            ("a", "use crate::B;"),
            ("b", "use std::fmt;\nuse crate::a::A;"),
        ];
        assert_eq!(names(&texts), [": a b"]);
    }

    #[test]
    fn tests_and_comments_do_not_count() {
        let texts = [
            ("", ""),
            (
                "a",
                "// use crate::b::B;\n/// [`crate::b::B`]\n#[cfg(test)]\nmod tests {\n    use crate::b::B;\n}",
            ),
            ("b", "use crate::a::A;"),
        ];
        assert_eq!(names(&texts), Vec::<String>::new());
    }
}
