//! Which file imports which: every path of a module, resolved to the file that defines its name.

use std::collections::BTreeSet;
use std::path::PathBuf;

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::Visit;

use super::modules::{Module, ModulePath, ModuleTree};

/// Largest number of re-exports of a name that are followed.
const MAX_HOPS: usize = 8;

/// Pairs of files (importing, imported) of a crate.
pub fn between_files(tree: &ModuleTree) -> BTreeSet<(PathBuf, PathBuf)> {
    let mut pairs = BTreeSet::new();
    for (path, module) in &tree.modules {
        let mut paths = Paths::default();
        module.items.iter().for_each(|item| paths.visit_item(item));
        let imported = module.uses.iter().map(|used| used.path.clone());
        // A name that is only handed on is not used here: it counts where somebody asks for it.
        let private = imported.filter(|used| is_used(module, used, &paths));
        for named in private.chain(paths.found.iter().cloned()) {
            if let Some(file) = resolve(tree, path, &named, MAX_HOPS)
                && file != module.file
            {
                pairs.insert((module.file.clone(), file));
            }
        }
    }
    pairs
}

/// Whether an imported name occurs in the module's own code. Traits and globs are used unseen.
fn is_used(module: &Module, used: &[String], paths: &Paths) -> bool {
    let name = module
        .uses
        .iter()
        .find(|handed| handed.path == used)
        .and_then(|handed| handed.name.clone());
    match name {
        Some(name) => paths.words.contains(&name) || (name == "_"),
        None => !module.items.is_empty(),
    }
}

/// The file that defines what `named` names, seen from the module at `here`; none for names of
/// other crates.
fn resolve(tree: &ModuleTree, here: &ModulePath, named: &[String], hops: usize) -> Option<PathBuf> {
    if hops == 0 {
        return None;
    }
    let (mut at, mut rest) = start(tree, here, named)?;
    while let Some((next, others)) = rest.split_first() {
        let mut below = at.clone();
        below.push(next.clone());
        if !tree.modules.contains_key(&below) {
            break;
        }
        at = below;
        rest = others;
    }
    let module = tree.modules.get(&at)?;
    let Some(name) = rest.first() else {
        return Some(module.file.clone());
    };
    if module.defines.contains(name) {
        return Some(module.file.clone());
    }
    let known = module
        .uses
        .iter()
        .filter(|used| used.name.as_ref() == Some(name));
    let globs = module.uses.iter().filter(|used| used.name.is_none());
    known.chain(globs).find_map(|used| {
        let mut path = used.path.clone();
        if used.name.is_none() {
            path.push(name.clone());
        }
        path.extend_from_slice(&rest[1..]);
        resolve(tree, &at, &path, hops - 1)
    })
}

/// Where a path starts: the module its first words lead to, and the words after them.
fn start<'a>(
    tree: &ModuleTree,
    here: &ModulePath,
    named: &'a [String],
) -> Option<(ModulePath, &'a [String])> {
    let (first, rest) = named.split_first()?;
    match first.as_str() {
        "crate" => Some((Vec::new(), rest)),
        "self" => Some((here.clone(), rest)),
        "super" => {
            let mut at = here.clone();
            at.pop()?;
            let mut rest = rest;
            while let Some((word, others)) = rest.split_first()
                && word == "super"
            {
                at.pop()?;
                rest = others;
            }
            Some((at, rest))
        }
        word => {
            let mut below = here.clone();
            below.push(word.to_owned());
            let module = tree.modules.get(here)?;
            let known = tree.modules.contains_key(&below)
                || module.defines.contains(word)
                || module
                    .uses
                    .iter()
                    .any(|used| used.name.as_deref() == Some(word));
            known.then(|| (here.clone(), named))
        }
    }
}

/// Paths of more than one word in code, and every word.
#[derive(Default)]
struct Paths {
    found: BTreeSet<Vec<String>>,
    words: BTreeSet<String>,
}

impl<'a> Visit<'a> for Paths {
    fn visit_path(&mut self, path: &'a syn::Path) {
        let words: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        self.words.extend(words.iter().cloned());
        if words.len() > 1 {
            self.found.insert(words);
        }
        syn::visit::visit_path(self, path);
    }

    fn visit_expr_method_call(&mut self, call: &'a syn::ExprMethodCall) {
        self.words.insert(call.method.to_string());
        syn::visit::visit_expr_method_call(self, call);
    }

    fn visit_macro(&mut self, call: &'a syn::Macro) {
        self.visit_path(&call.path);
        self.add_tokens(call.tokens.clone());
    }

    fn visit_item_use(&mut self, _: &'a syn::ItemUse) {}
}

impl Paths {
    /// Adds the words and paths of a macro's arguments, which `syn` leaves as tokens.
    fn add_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(word) => {
                    if colons != 2 {
                        self.add_path(&mut path);
                    }
                    path.push(word.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                other => {
                    self.add_path(&mut path);
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.add_tokens(group.stream());
                    }
                }
            }
        }
        self.add_path(&mut path);
    }

    /// Adds a path that ended, and empties it.
    fn add_path(&mut self, path: &mut Vec<String>) {
        self.words.extend(path.iter().cloned());
        if path.len() > 1 {
            self.found.insert(path.clone());
        }
        path.clear();
    }
}
