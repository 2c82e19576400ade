use super::*;

fn sweep(keys: &[&str]) -> Result<SceneSweep, SweepError> {
    SceneSweep::new(keys.iter().map(|key| SweptKey::parse(key)).collect::<Result<_, _>>()?)
}

fn message<T: core::fmt::Debug>(result: Result<T, SweepError>) -> String {
    result.unwrap_err().to_string()
}

#[test]
#[expect(clippy::float_cmp, reason = "the numbers that the decimals stand for")]
fn steps_have_both_ends_and_short_decimals() {
    let values = |text: &str| SweptKey::parse(text).unwrap().values().to_vec();
    assert_eq!(values("a=-5:5:11"), (-5..=5).map(f64::from).collect::<Vec<_>>());
    assert_eq!(values("a = 0 : 1 : 11")[3], 0.3);
    assert_eq!(values("a=0.1:0.7:3"), [0.1, 0.4, 0.7]);
    assert_eq!(values("a=3:1:3"), [3.0, 2.0, 1.0]);
    assert_eq!(values("a=2:2:1"), [2.0]);
    assert_eq!(values("a=1e-3,2,-7.5"), [1e-3, 2.0, -7.5]);
    assert!(values("a=-1:1:3")[1].is_sign_positive());
}

#[test]
fn errors_name_the_key_the_value_and_what_was_expected() {
    let of = |text: &str| message(SweptKey::parse(text));
    assert_eq!(of("a=1,x"), "a value of `a` is `x`: expected a finite number");
    assert_eq!(of("a=1,,2"), "a value of `a` is ``: expected a finite number");
    assert_eq!(of("a=inf"), "a value of `a` is `inf`: expected a finite number");
    let count = |text| {
        format!(
            "the count of values of `a` is `{text}`: expected a whole number of 2 or more, or 1 where START \
             is STOP"
        )
    };
    assert_eq!(of("a=0:1:0"), count("0"));
    assert_eq!(of("a=0:1:1"), count("1"));
    assert_eq!(of("a=0:1:2.5"), count("2.5"));
    let steps = "the values of `a` are `1:2`: expected START:STOP:COUNT, as in -5:5:11";
    assert_eq!(of("a=1:2"), steps);
    assert_eq!(of("a=1,2,1"), "`a` has the value 1 twice: expected different values");
    assert_eq!(of("a=2:2:3"), "`a` has the value 2 twice: expected different values");
    assert!(of("a").starts_with("`a`: expected KEY=START:STOP:COUNT, as in"));
    assert!(of("=1").starts_with("`=1`: expected"));
    let twice = "the key `a` has values twice: expected each key once";
    assert_eq!(message(sweep(&["a=1", "a=2"])), twice);
    let many = "the sweep has 1000000 images: expected 100000 or less";
    assert_eq!(message(sweep(&["a=0:1:1000", "b=0:1:1000"])), many);
    assert_eq!(message(SweptKey::parse("a=0:1:1000000")), many);
    assert!(message(sweep(&[])).starts_with("no key has values"));
}

#[test]
fn values_are_those_of_toml() {
    let sweep = sweep(&["a.b=1,1e20,0.5"]).unwrap();
    let values = |image| sweep.overrides(image)[0].value.clone();
    assert_eq!([0, 1, 2].map(values), ["1", "1e20", "0.5"]);
    assert_eq!(sweep.overrides(0)[0].key, "a.b");
}

#[test]
fn names_have_values_and_numbers() {
    let sweep = sweep(&["a.x=0:1:2", "b.x=1,2,3", "c=5,6"]).unwrap();
    let names = |text| NameTemplate::parse(text, &sweep)?.names(&sweep);
    let of_all = names("{{{a.x}_{b.x}_{c}}}{number}.npy").unwrap();
    assert_eq!(of_all.len(), 12);
    assert_eq!(of_all[7].to_str(), Some("{1_1_6}07.npy"));
    assert_eq!(
        message(names("{x}.npy")),
        "the output `{x}.npy` has `{x}`: expected {a.x}, {b.x}, {c} or {number}"
    );
    assert_eq!(
        message(names("{c}.npy")),
        "the output `5.npy` is that of a.x = 0, b.x = 1, c = 5 and of a.x = 0, b.x = 2, c = 5: expected a \
         name with {a.x}, {b.x}, {c} or {number}"
    );
    for single in ["{c", "c}", "{c}}_{number}.npy"] {
        let expected = "has a single brace: expected {KEY}, or two braces for one in the name";
        assert!(message(names(single)).ends_with(expected), "{single}");
    }
}
